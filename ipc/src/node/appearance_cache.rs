//! Remembers the appearance of objects while nothing hides them.

use heapless::Vec;
use nsrm_core::MAX_OBJECTS;
use nsrm_core::model::OBJECT_EMBEDDING;

use crate::message::{CameraFrame, ObjectMessage};

/// The embeddings of a camera's objects from when each was completely visible. The crop of a partly
/// hidden object also shows what hides it.
#[derive(Debug, Default)]
pub(super) struct AppearanceCache {
    /// From the last frame: a new publisher has other objects.
    sequence: u64,
    known: Vec<Appearance, MAX_OBJECTS>,
}

#[derive(Debug)]
struct Appearance {
    id: u32,
    embedding: [f32; OBJECT_EMBEDDING],
}

impl AppearanceCache {
    /// Remembers objects that are completely visible, and gives the others their earlier
    /// appearance.
    ///
    /// * `objects`: the objects of the frame's boxes, in the same order
    pub(super) fn recall(&mut self, header: &CameraFrame, objects: &mut [ObjectMessage]) {
        if header.sequence <= self.sequence {
            self.known.clear();
        }
        self.sequence = header.sequence;
        for (found, object) in header.boxes.iter().zip(objects) {
            let known = self
                .known
                .iter_mut()
                .find(|appearance| appearance.id == object.id);
            match (found.covered, known) {
                (0, Some(known)) => known.embedding = object.embedding,
                (0, None) => self.remember(object, header),
                (_, Some(known)) => object.embedding = known.embedding,
                (_, None) => {}
            }
        }
    }

    /// Whether the appearance of an object is known.
    pub(super) fn knows(&self, id: u32) -> bool {
        self.known.iter().any(|appearance| appearance.id == id)
    }

    /// If all places are taken, it replaces an object that is not in the frame, of which there is
    /// one.
    fn remember(&mut self, object: &ObjectMessage, header: &CameraFrame) {
        let appearance = Appearance {
            id: object.id,
            embedding: object.embedding,
        };
        let Err(appearance) = self.known.push(appearance) else {
            return;
        };
        let is_here = |id| header.boxes.iter().any(|found| found.id == id);
        if let Some(place) = self.known.iter_mut().find(|known| !is_here(known.id)) {
            *place = appearance;
        }
    }
}

#[cfg(test)]
mod tests {
    use nsrm_core::MAX_OBJECTS;
    use nsrm_core::model::{LOCATION, OBJECT_EMBEDDING};

    use super::AppearanceCache;
    use crate::message::{CameraFrame, DetectedBox, ObjectMessage};

    const BOX: [f32; LOCATION] = [0.1, 0.1, 0.3, 0.3, 0.9];

    /// The appearances given to the objects of a frame, each whole or not and all with one
    /// appearance.
    fn see(
        appearances: &mut AppearanceCache,
        sequence: u64,
        objects: &[(u32, bool)],
        appearance: f32,
    ) -> Vec<f32> {
        let mut header = CameraFrame {
            sequence,
            count: objects.len() as u32,
            ..CameraFrame::default()
        };
        let mut seen = Vec::new();
        for (place, (id, is_whole)) in objects.iter().copied().enumerate() {
            header.boxes[place] = DetectedBox::whole(id, BOX);
            header.boxes[place].covered = u32::from(!is_whole);
            seen.push(ObjectMessage {
                id,
                location: BOX,
                embedding: [appearance; OBJECT_EMBEDDING],
            });
        }
        appearances.recall(&header, &mut seen);
        seen.iter().map(|object| object.embedding[0]).collect()
    }

    #[test]
    fn what_is_hidden_looks_as_it_did_whole() {
        let mut appearances = AppearanceCache::default();
        // Never completely visible: nothing better is known.
        assert_eq!(see(&mut appearances, 1, &[(5, false)], 1.0), [1.0]);
        let both = [(4, true), (5, true)];
        assert_eq!(see(&mut appearances, 2, &both, 2.0), [2.0, 2.0]);
        // In another order, too.
        let hidden = [(5, false), (4, true)];
        assert_eq!(see(&mut appearances, 3, &hidden, 3.0), [2.0, 3.0]);
        assert_eq!(see(&mut appearances, 4, &[(4, false)], 4.0), [3.0]);
        // A restarted camera: object 4 is another one.
        assert_eq!(see(&mut appearances, 1, &[(4, false)], 5.0), [5.0]);
    }

    #[test]
    fn who_has_long_left_gives_room() {
        let mut appearances = AppearanceCache::default();
        let first: Vec<_> = (1..=MAX_OBJECTS as u32).map(|id| (id, true)).collect();
        let then: Vec<_> = first.iter().map(|(id, _)| (100 + id, true)).collect();
        see(&mut appearances, 1, &first, 1.0);
        see(&mut appearances, 2, &then, 2.0);
        let hidden: Vec<_> = then.iter().map(|(id, _)| (*id, false)).collect();
        let given = see(&mut appearances, 3, &hidden, 3.0);
        assert_eq!(given, [2.0; MAX_OBJECTS]);
    }
}
