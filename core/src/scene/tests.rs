use std::string::ToString;

use super::*;
use crate::camera::CameraError;
use crate::fixture;

fn changed(change: impl FnOnce(&mut RawScene)) -> Result<(), SceneError> {
    let model = fixture::model();
    let mut raw = *fixture::scene(&model).raw();
    change(&mut raw);
    Scene::new(raw, &model).map(|_| ())
}

#[test]
fn what_the_scene_says_of_itself_is_checked() {
    assert_eq!(changed(|_| ()), Ok(()));
    assert_eq!(
        changed(|raw| raw.header.schema = 2),
        Err(SceneError::Schema { got: 2 })
    );
    assert_eq!(
        changed(|raw| raw.header.frame = 1),
        Err(SceneError::Frame { got: 1 })
    );
    let tag = fixture::model().tag();
    assert_eq!(
        changed(|raw| raw.header.model_tag = 5),
        Err(SceneError::ModelTag {
            expected: tag,
            got: 5
        })
    );
    assert_eq!(
        changed(|raw| raw.camera.fy = f32::NAN),
        Err(SceneError::Camera(CameraError::NotFinite("fy")))
    );
    for count in [17, u32::MAX] {
        assert_eq!(
            changed(|raw| raw.count = count),
            Err(SceneError::TooManyObjects { count })
        );
    }
}

#[test]
fn each_fault_of_an_object_is_named() {
    let fault = |change: fn(&mut ObservedObject)| {
        let error = changed(|raw| change(&mut raw.objects[1])).unwrap_err();
        let SceneError::Object {
            index: 1, fault, ..
        } = error
        else {
            panic!("{error}");
        };
        fault
    };
    assert_eq!(fault(|o| o.id = 0), ObjectFault::ZeroId);
    assert_eq!(fault(|o| o.id = 11), ObjectFault::RepeatedId);
    assert_eq!(
        fault(|o| o.location[4] = f32::INFINITY),
        ObjectFault::LocationNotFinite
    );
    assert_eq!(
        fault(|o| o.embedding[63] = f32::NAN),
        ObjectFault::EmbeddingNotFinite
    );
    assert_eq!(fault(|o| o.location[3] = 0.1), ObjectFault::BoxNotOrdered);
    assert_eq!(
        fault(|o| o.location[0] = -0.01),
        ObjectFault::BoxOutsideImage
    );
    assert_eq!(
        fault(|o| o.location[3] = 1.01),
        ObjectFault::BoxOutsideImage
    );
    assert_eq!(
        fault(|o| o.location[4] = 0.0),
        ObjectFault::DepthNotPositive
    );
    assert_eq!(
        changed(|raw| raw.objects[2].id = 12)
            .unwrap_err()
            .to_string(),
        "scene: object 12 (place 2): id is already taken by an object before it"
    );
}

#[test]
fn what_stands_behind_the_objects_is_not_looked_at() {
    assert_eq!(changed(|raw| raw.objects[3].id = 11), Ok(()));
    assert_eq!(
        changed(|raw| raw.objects[15].location[0] = f32::NAN),
        Ok(())
    );
}

#[test]
fn a_full_scene_gives_the_next_object_back() {
    let model = fixture::model();
    let mut raw = RawScene::empty(&model, fixture::camera());
    for id in 1..=16 {
        let object = fixture::object(id, fixture::RED, fixture::SMALL, 0.5, 0.5);
        assert_eq!(raw.push(object), Ok(()));
    }
    assert!(raw.push(ObservedObject::EMPTY).is_err());
    let scene = Scene::new(raw, &model).unwrap();
    assert_eq!((scene.objects().len(), scene.objects()[15].id), (16, 16));
}
