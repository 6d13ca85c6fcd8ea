use iceoryx2::port::notifier::Notifier as EventNotifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::port::{ReceiveError, SendError};
use iceoryx2::prelude::ipc;
use iceoryx2::sample::Sample;

use super::error::SendFailure;
use super::quality::Carried;
use crate::message::CameraFrame;

/// Wakes those who listen to a service.
#[derive(Debug)]
pub struct Notifier {
    notifier: EventNotifier<ipc::Service>,
}

impl Notifier {
    pub(super) const fn new(notifier: EventNotifier<ipc::Service>) -> Self {
        Self { notifier }
    }

    /// Wakes them. Who could not be woken looks a little later by itself: everyone
    /// who waits does so for a bounded time.
    pub fn notify(&self) {
        let _ = self.notifier.notify();
    }
}

/// Sends messages of one type.
#[derive(Debug)]
pub struct Sender<M: Carried> {
    publisher: Publisher<ipc::Service, M, ()>,
    notifier: Notifier,
}

impl<M: Carried> Sender<M> {
    pub(super) const fn new(publisher: Publisher<ipc::Service, M, ()>, notifier: Notifier) -> Self {
        Self {
            publisher,
            notifier,
        }
    }

    /// Sends a message and rings; says to how many. Never waits.
    pub fn send(&self, message: &M) -> Result<usize, SendFailure> {
        let receivers = self
            .publisher
            .send_copy(*message)
            .map_err(|error| match error {
                SendError::UnableToDeliver => SendFailure::Full,
                error => SendFailure::Iceoryx(format!("{error:?}")),
            })?;
        self.notifier.notify();
        Ok(receivers)
    }

    /// Gives receivers that came since the last message what the service keeps for
    /// them; iceoryx2 does so only when its publisher acts. To be called a few times
    /// a second where messages are rare.
    pub fn update_connections(&self) {
        // Who could not be reached is reached by the next message, or is gone.
        let _ = self.publisher.update_connections();
    }
}

/// Receives messages of one type.
#[derive(Debug)]
pub struct Receiver<M: Carried> {
    subscriber: Subscriber<ipc::Service, M, ()>,
}

impl<M: Carried> Receiver<M> {
    pub(super) const fn new(subscriber: Subscriber<ipc::Service, M, ()>) -> Self {
        Self { subscriber }
    }

    /// The next message, in place; `None` when there is none now.
    pub fn receive(&self) -> Result<Option<Sample<ipc::Service, M, ()>>, ReceiveError> {
        self.subscriber.receive()
    }

    /// What waits now, in order of each publisher. Ends after as many as can wait, so
    /// that who sends without end keeps nobody from its work; what can't be read now is
    /// there for the next call.
    pub fn waiting(&self) -> impl Iterator<Item = Sample<ipc::Service, M, ()>> {
        let most = M::QUALITY.buffer * M::QUALITY.publishers;
        (0..most).map_while(|_| self.receive().ok().flatten())
    }
}

/// Publishes frames.
#[derive(Debug)]
pub struct FramesOut {
    publisher: Publisher<ipc::Service, [u8], CameraFrame>,
    notifier: Notifier,
}

impl FramesOut {
    pub(super) const fn new(
        publisher: Publisher<ipc::Service, [u8], CameraFrame>,
        notifier: Notifier,
    ) -> Self {
        Self {
            publisher,
            notifier,
        }
    }

    /// Publishes a frame that is written where its readers will find it; says to how
    /// many.
    ///
    /// * `bytes`: of the image, seven a pixel: see [`CameraFrame`]
    /// * `write`: is given the image's place, with what an earlier frame has left there;
    ///   clearing it would take as long as writing it
    pub fn send(
        &self,
        header: CameraFrame,
        bytes: usize,
        write: impl FnOnce(&mut [u8]),
    ) -> Result<usize, SendFailure> {
        let says = |error: &dyn core::fmt::Debug| SendFailure::Iceoryx(format!("{error:?}"));
        let frame = self
            .publisher
            .loan_slice_uninit(bytes)
            .map_err(|error| says(&error))?;
        // SAFETY: bytes of any value are bytes, and shared memory has been written since it
        // was mapped: with 0 by the system, then by earlier frames.
        let mut frame = unsafe { frame.assume_init() };
        *frame.user_header_mut() = header;
        write(frame.payload_mut());
        let receivers = frame.send().map_err(|error| says(&error))?;
        self.notifier.notify();
        Ok(receivers)
    }
}

/// Receives frames.
#[derive(Debug)]
pub struct Frames {
    subscriber: Subscriber<ipc::Service, [u8], CameraFrame>,
}

impl Frames {
    pub(super) const fn new(subscriber: Subscriber<ipc::Service, [u8], CameraFrame>) -> Self {
        Self { subscriber }
    }

    /// The latest frame, in place; `None` when there is none that was not received.
    pub fn receive(&self) -> Result<Option<Sample<ipc::Service, [u8], CameraFrame>>, ReceiveError> {
        self.subscriber.receive()
    }
}
