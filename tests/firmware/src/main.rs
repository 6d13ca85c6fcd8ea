//! Plans on a Cortex-M what the host gives, and prints what comes of it, with the number of
//! instructions and bytes of stack that it took. `cargo footprint` builds and runs it under QEMU.

#![no_std]
#![no_main]

mod input;
mod measure;

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::task::Poll;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use input::Reader;
use measure::{Clock, stack};
use nsrm_core::{Model, Planner, PlanningTask, Scene};
#[cfg(not(feature = "int8"))]
use nsrm_tabletop::TABLETOP as BUILT_IN;
#[cfg(feature = "int8")]
use nsrm_tabletop::TABLETOP_INT8 as BUILT_IN;

/// The built-in model. A program that only plans has no weights of vision.
fn model() -> &'static Model<'static> {
    #[cfg(feature = "vision")]
    return &BUILT_IN;
    #[cfg(not(feature = "vision"))]
    {
        static PLANNING: Model<'static> = BUILT_IN.without_vision();
        &PLANNING
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    hprintln!("panic");
    fail()
}

fn fail() -> ! {
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}

/// Static memory, as controllers have it.
struct Static<T>(UnsafeCell<MaybeUninit<T>>);

// SAFETY: there is one thread.
unsafe impl<T> Sync for Static<T> {}

impl<T> Static<T> {
    const fn new() -> Self {
        Self(UnsafeCell::new(MaybeUninit::uninit()))
    }

    /// Puts a value here.
    ///
    /// # Safety
    /// Nobody uses an earlier one.
    #[allow(clippy::mut_from_ref)]
    unsafe fn put(&self, value: T) -> &mut T {
        // SAFETY: the caller's promise.
        unsafe { &mut *self.0.get() }.write(value)
    }
}

static SCENE: Static<Scene> = Static::new();
static TASK: Static<PlanningTask<'static, &'static Scene, &'static str>> = Static::new();

#[entry]
fn main() -> ! {
    let Some(peripherals) = cortex_m::Peripherals::take() else {
        fail()
    };
    let mut clock = Clock::start(peripherals.SYST);
    let (_, ticks) = clock.ticks(|| {});
    hprintln!("nothing ticks {}", ticks);
    if run(&mut clock).is_none() {
        hprintln!("the input is not as described");
        fail();
    }
    loop {
        debug::exit(debug::EXIT_SUCCESS);
    }
}

fn run(clock: &mut Clock) -> Option<()> {
    let mut input = Reader::open()?;
    let scene = observe(clock, &mut input)?;
    for _ in 0..input.integer()? {
        let sentence = input.text()?;
        plan(clock, scene, sentence);
    }
    Some(())
}

// These have names in the program: `cargo footprint` bounds the stack of what they call.

#[unsafe(no_mangle)]
#[inline(never)]
fn plan_begin(
    planner: &Planner<'static>,
    scene: &'static Scene,
    sentence: &'static str,
) -> &'static mut PlanningTask<'static, &'static Scene, &'static str> {
    // SAFETY: the task before is done.
    unsafe { TASK.put(planner.begin(scene, sentence)) }
}

/// Whether it is done.
#[unsafe(no_mangle)]
#[inline(never)]
fn plan_poll(task: &mut PlanningTask<'static, &'static Scene, &'static str>) -> bool {
    task.poll().is_ready()
}

/// Whether there is a scene, once it is done.
#[cfg(feature = "vision")]
#[unsafe(no_mangle)]
#[inline(never)]
fn observe_poll(task: &mut nsrm_core::vision::ObservationTask<'static>) -> Option<bool> {
    match task.poll() {
        Poll::Pending => None,
        Poll::Ready(Err(_)) => Some(false),
        Poll::Ready(Ok(scene)) => {
            // SAFETY: there is no other.
            unsafe { SCENE.put(scene) };
            Some(true)
        }
    }
}

fn plan(clock: &mut Clock, scene: &'static Scene, sentence: &'static str) {
    let planner = Planner::new(model());
    let ((task, begin), begin_stack) =
        stack(|| clock.ticks(|| plan_begin(&planner, scene, sentence)));
    let (mut total, mut largest, mut polls) = (begin, 0, 0);
    let ((), poll_stack) = stack(|| {
        loop {
            let (is_done, ticks) = clock.ticks(|| plan_poll(task));
            total += ticks;
            largest = largest.max(ticks);
            polls += 1;
            if is_done {
                break;
            }
        }
    });
    hprintln!(
        "plan ticks {} begin {} polls {} largest {}",
        total,
        begin,
        polls,
        largest
    );
    hprintln!("stack begin {} poll {}", begin_stack, poll_stack);
    match task.poll() {
        Poll::Ready(Ok(plan)) => {
            for goal in plan.sub_goals() {
                let pose = &goal.pose;
                let numbers = pose
                    .translation
                    .vector
                    .iter()
                    .chain(pose.rotation.coords.iter());
                hprintln!("goal {}", goal.object);
                numbers.for_each(|number| hprintln!("{:08x}", number.to_bits()));
            }
            hprintln!("confidence {:08x}", plan.confidence().to_bits());
        }
        Poll::Ready(Err(refusal)) => hprintln!("refused {}", refusal.kind()),
        Poll::Pending => fail(),
    }
}

/// The scene as the host gives it.
#[cfg(not(feature = "vision"))]
fn observe(_: &mut Clock, input: &mut Reader) -> Option<&'static Scene> {
    use nsrm_core::RawScene;

    let bytes = input.bytes(size_of::<RawScene>())?;
    let raw = bytes.as_ptr().cast::<RawScene>();
    if !raw.is_aligned() {
        return None;
    }
    // SAFETY: as many bytes, aligned, and any are a raw scene.
    let scene = Scene::new(unsafe { raw.read() }, model()).ok()?;
    // SAFETY: there is no other.
    Some(unsafe { SCENE.put(scene) })
}

/// The scene in an image that the host gives.
#[cfg(feature = "vision")]
fn observe(clock: &mut Clock, input: &mut Reader) -> Option<&'static Scene> {
    use nsrm_core::vision::{Detection, ObservationTask, RgbImage, Stamp};
    use nsrm_core::{Camera, MAX_OBJECTS};

    static OBSERVER: Static<ObservationTask<'static>> = Static::new();
    static DETECTIONS: Static<[Detection; MAX_OBJECTS]> = Static::new();

    let [width, height] = [input.integer()?, input.integer()?];
    let [fx, fy, cx, cy] = input.numbers()?;
    let (position, orientation) = (input.numbers()?, input.numbers()?);
    let camera = Camera {
        width,
        height,
        fx,
        fy,
        cx,
        cy,
        position,
        orientation,
    };
    // SAFETY: there are no others.
    let detections = unsafe { DETECTIONS.put([Detection::whole(0, [0.0; 5]); MAX_OBJECTS]) };
    let count = usize::try_from(input.integer()?).ok()?;
    for detection in detections.get_mut(..count)? {
        let id = input.integer()?;
        *detection = Detection {
            id,
            visible: input.numbers()?,
            location: input.numbers()?,
        };
    }
    let row = usize::try_from(width).ok()?.checked_mul(3)?;
    let pixels = input.bytes(row.checked_mul(usize::try_from(height).ok()?)?)?;
    let image = RgbImage::new(pixels, width, height, row).ok()?;
    let detections = detections.get(..count)?;
    let task = ObservationTask::new(model(), image, camera, detections, Stamp::default());
    // SAFETY: there is no other.
    let task = unsafe { OBSERVER.put(task.ok()?) };
    let (mut total, mut largest, mut polls) = (0, 0, 0);
    let (is_scene, bytes) = stack(|| {
        loop {
            let (is_done, ticks) = clock.ticks(|| observe_poll(task));
            total += ticks;
            largest = largest.max(ticks);
            polls += 1;
            if let Some(is_scene) = is_done {
                break is_scene;
            }
        }
    });
    hprintln!(
        "observe ticks {} polls {} largest {}",
        total,
        polls,
        largest
    );
    hprintln!("stack observe {}", bytes);
    // SAFETY: it is there.
    is_scene.then(|| unsafe { (*SCENE.0.get()).assume_init_ref() })
}
