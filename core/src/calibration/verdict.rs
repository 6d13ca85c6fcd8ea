use super::resting::{Arrangement, Rest, Seen, length_m, sizes};
use super::{CalibrationFault, Measured};
use crate::model::Model;

/// The objects' heights lie on a line if their root mean square distance from it, metres,
/// is less.
const ON_A_LINE_M: f32 = 0.001;

impl Arrangement {
    /// Why more objects disagree than may, if so.
    pub(super) fn fault(&self, model: &Model<'_>, tolerance_m: f32) -> Option<CalibrationFault> {
        let (mut agreeing, mut off, mut unexplained) = (0_u8, Tally::new(), Tally::new());
        for (seen, rest) in self.whole() {
            if !rest.fits {
                let expected_m = nearest_width(model, seen.width_m);
                off.add(seen, Measured::Width, seen.width_m, expected_m);
            } else if rest.off_m.abs() <= tolerance_m {
                agreeing = agreeing.saturating_add(1);
            } else {
                let tally = if rest.is_on_table {
                    &mut off
                } else {
                    &mut unexplained
                };
                tally.add(seen, Measured::Height, seen.height_m(), rest.height_m);
            }
        }
        if agreeing == 0 && off.count == 0 {
            off = unexplained;
        }
        let whole = agreeing.saturating_add(off.count);
        // More than a third of them.
        if u16::from(off.count) * 3 > u16::from(whole) {
            return off.fault(whole);
        }
        self.slope(tolerance_m)
    }

    /// How the table seems to rise across the image, if by more than the tolerance.
    fn slope(&self, tolerance_m: f32) -> Option<CalibrationFault> {
        let points = || {
            let fitting = self.whole().filter(|(_, rest)| rest.fits);
            fitting.filter(|(_, rest)| rest.is_on_table || rest.off_m.abs() <= tolerance_m)
        };
        let count = points().count() as f32;
        let mean = |of: fn((&Seen, &Rest)) -> f32| points().map(of).sum::<f32>() / count;
        let (mean_across, mean_off) = (
            mean(|(seen, _)| seen.across_m),
            mean(|(_, rest)| rest.off_m),
        );
        let (mut spread, mut both, mut height) = (0.0, 0.0, 0.0);
        for (seen, rest) in points() {
            let (across, off) = (seen.across_m - mean_across, rest.off_m - mean_off);
            spread += across * across;
            both += across * off;
            height += off * off;
        }
        let slope = both / spread;
        let left = points().min_by(|(one, _), (other, _)| one.across_m.total_cmp(&other.across_m));
        let right = points().max_by(|(one, _), (other, _)| one.across_m.total_cmp(&other.across_m));
        let ((left, _), (right, _)) = left.zip(right)?;
        let rise_m = slope * (right.across_m - left.across_m);
        let from_line = (height - slope * both) / count;
        // Not so with a single object, of which the spread is 0 and the slope no number.
        let is_line = count == 2.0 || from_line < ON_A_LINE_M * ON_A_LINE_M;
        (is_line && rise_m.abs() > tolerance_m).then_some(CalibrationFault {
            object: if rise_m > 0.0 { right.id } else { left.id },
            quantity: Measured::Rise,
            measured_m: rise_m.abs(),
            expected_m: 0.0,
            // At most MAX_OBJECTS.
            disagreeing: points().count() as u8,
            whole: points().count() as u8,
            cause: None,
        })
    }
}

/// Objects that disagree: how many, and the one that does most; widths before heights, which
/// are wrong by themselves where widths are.
#[derive(Debug, Clone, Copy)]
struct Tally {
    count: u8,
    worst: Option<(f32, CalibrationFault)>,
}

impl Tally {
    const fn new() -> Self {
        Self {
            count: 0,
            worst: None,
        }
    }

    fn add(&mut self, seen: &Seen, quantity: Measured, measured_m: f32, expected_m: f32) {
        self.count = self.count.saturating_add(1);
        let by_m = (measured_m - expected_m).abs();
        let is_worse = |(most_m, before): (f32, CalibrationFault)| {
            if quantity == before.quantity {
                // What is not a number is the greatest.
                by_m.total_cmp(&most_m).is_gt()
            } else {
                quantity == Measured::Width
            }
        };
        if self.worst.is_none_or(is_worse) {
            let fault = CalibrationFault {
                object: seen.id,
                quantity,
                measured_m,
                expected_m,
                disagreeing: 0,
                whole: 0,
                cause: None,
            };
            self.worst = Some((by_m, fault));
        }
    }

    fn fault(&self, whole: u8) -> Option<CalibrationFault> {
        self.worst.map(|(_, fault)| CalibrationFault {
            disagreeing: self.count,
            whole,
            ..fault
        })
    }
}

/// The width nearest to this one that an object of the domain may have.
fn nearest_width(model: &Model<'_>, width_m: f32) -> f32 {
    let widths = sizes(model).flat_map(|[x, y, _]| [x.min(y), length_m(x, y)]);
    let off_m = |bound_m: &f32| (bound_m - width_m).abs();
    let nearest = widths.min_by(|one, other| off_m(one).total_cmp(&off_m(other)));
    // There are widths where an object has a place to rest.
    nearest.unwrap_or(0.0)
}
