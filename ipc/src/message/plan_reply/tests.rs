use super::*;
use nsrm_core::Refusal;

const TO: ReplyTo = ReplyTo {
    client: 1,
    request: 7,
    plan: 9,
    number: 2,
};

#[test]
fn a_program_is_checked_step_by_step() {
    let mut good = PlanReply::new(TO, Status::Planned).saying("Action(…)");
    good.count = 2;
    good.steps[1].object_id = 4;
    good.steps[1].orientation = [0.0, 0.0, 0.6, 0.8];
    let program = "Action(…)";
    let steps = &good.steps[..2];
    assert_eq!(good.read(), Ok(Reply::Planned { steps, program }));
    assert_eq!(
        [false, true],
        [0, 1].map(|step: usize| steps[step].is_grounded())
    );
    for count in [0, 9, u32::MAX] {
        let broken = PlanReply { count, ..good };
        assert_eq!(broken.read(), Err(PlanReplyError::Count(count)));
    }
    type Break = fn(&mut StepMessage);
    let cases: [Break; 6] = [
        |step| step.position[0] = f32::NAN,
        |step| step.confidence[5] = f32::INFINITY,
        |step| step.object_score = f32::NAN,
        |step| step.orientation[2] = 0.0,
        |step| step.reference_count = 5,
        |step| step.object_relation_count = 3,
    ];
    for break_it in cases {
        let mut broken = good;
        break_it(&mut broken.steps[1]);
        assert_eq!(broken.read(), Err(PlanReplyError::Broken { step: 1 }));
    }
    let broken = PlanReply { status: 8, ..good };
    assert_eq!(broken.read(), Err(PlanReplyError::Status(8)));
    let broken = PlanReply { step: 8, ..good };
    assert_eq!(broken.read(), Err(PlanReplyError::Step(8)));
}

#[test]
fn a_reason_is_named_and_its_text_checked() {
    let refused = PlanReply::refused(TO, "busy", "wait");
    let (reason, message) = ("busy", "wait");
    assert_eq!(refused.read(), Ok(Reply::Failed { reason, message }));
    for reason in [0, 1000, u32::MAX] {
        let broken = PlanReply { reason, ..refused };
        assert_eq!(broken.read(), Err(PlanReplyError::Reason(reason)));
    }
    let broken = PlanReply {
        message_length: 2000,
        ..refused
    };
    assert_eq!(broken.read(), Err(PlanReplyError::Text));
}

#[test]
fn every_failure_has_a_number() {
    let step = 0;
    let object = 1;
    for why in [
        Failure::Refused(Refusal::NoWords),
        Failure::NoScene { last: None },
        Failure::NotAccepted { step },
        Failure::Unanswered { step },
        Failure::NoOutcome { step },
        Failure::ControllerLost { step },
        Failure::Unsuccessful {
            step,
            outcome: crate::message::Outcome::NoPath,
            objects: [0; 2],
        },
        Failure::NotThere {
            step,
            object,
            off_m: 0.1,
        },
        Failure::NotSeen { step, object },
        Failure::OtherObject {
            step,
            meant: object,
            found: 7,
        },
        Failure::Cancelled,
        Failure::CancelledUnconfirmed,
        Failure::ClockSetBack,
    ] {
        assert!(REASONS.contains(&why.kind()), "{why:?}");
    }
    let mut reasons = REASONS.to_vec();
    reasons.sort_unstable();
    reasons.dedup();
    assert_eq!(reasons.len(), REASONS.len());
}

#[test]
fn a_reason_without_a_number_still_ends_the_request() {
    let reply = PlanReply::refused(TO, "a_reason_of_later_versions", "no such thing");
    let expected = Reply::Failed {
        reason: "other",
        message: "no such thing",
    };
    assert_eq!(reply.read(), Ok(expected));
}
