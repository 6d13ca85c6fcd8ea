//! Properties of every plan, from any input; and models that continue where others refuse.

use nsrm_core::model::Thresholds;
use nsrm_core::{Model, Plan, Scene};

/// A model that is never unsure, and for which objects match from this score upwards.
pub fn reckless(model: Model<'_>, match_score: f32) -> Model<'_> {
    let mut model = model;
    model.header.thresholds = Thresholds::new()
        .with_match_score(match_score)
        .with_decision(0.0);
    model
}

/// Checks the properties of every plan.
pub fn check(model: &Model<'_>, plan: &Plan) {
    assert!(!plan.steps().is_empty());
    let steps = plan.program().steps().len();
    assert_eq!(plan.first() + plan.steps().len(), steps);
    for step in plan.steps() {
        let pose = &step.sub_goal.pose;
        let position: [f32; 3] = pose.translation.vector.into();
        assert!(model.header.work_space.contains(&position), "{position:?}");
        assert!((pose.rotation.coords.norm() - 1.0).abs() < 1e-3);
        assert!(step.location.iter().all(|number| number.is_finite()));
        assert_ne!(step.object.object, step.reference.object);
        assert_eq!(step.sub_goal.object, step.object.object);
        let confidence = step.confidence.joint();
        assert!((0.0..=1.0).contains(&confidence), "{confidence}");
    }
    let confidence = plan.confidence();
    let least = plan.steps().iter().map(|step| step.confidence.joint());
    assert!(
        (0.0..=least.fold(1.0, f32::min)).contains(&confidence),
        "{confidence}"
    );
    assert!(!plan.program().notation(model).to_string().is_empty());
}

/// Checks the properties of every plan made in this scene.
pub fn check_in(model: &Model<'_>, scene: &Scene, plan: &Plan) {
    check(model, plan);
    for step in plan.steps() {
        for grounding in [step.object, step.reference] {
            let object = &scene.objects()[usize::from(grounding.index)];
            assert_eq!(object.id, grounding.object);
        }
    }
}
