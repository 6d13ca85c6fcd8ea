/* The messages between processes.
 * Written by `cargo run -p nsrm-ipc --bin nsrm-bindings`; do not edit. */

#ifndef NSRM_MESSAGES_H
#define NSRM_MESSAGES_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define NSRM_ASSERT(condition, text) static_assert(condition, text)
#define NSRM_ALIGN_OF(type) alignof(type)
#else
#define NSRM_ASSERT(condition, text) _Static_assert(condition, text)
#define NSRM_ALIGN_OF(type) _Alignof(type)
#endif

/** Intrinsics and pose of a camera: pinhole without distortion; see
 *  `nsrm_core::camera::Camera`. */
typedef struct nsrm_camera_message {
    /** Width of the image in pixels. */
    uint32_t width;
    /** Height of the image in pixels. */
    uint32_t height;
    /** Focal length along x in pixels. */
    float fx;
    /** Focal length along y in pixels. */
    float fy;
    /** x of the principal point in pixels, from the image's left edge. */
    float cx;
    /** y of the principal point in pixels, from the image's upper edge. */
    float cy;
    /** Origin of the optical frame in the world's frame, metres. */
    float position[3];
    /** Orientation of the optical frame in the world's frame: x, y, z, w. */
    float orientation[4];
} nsrm_camera_message;
#define NSRM_CAMERA_MESSAGE_TYPE_NAME "nsrm.v1.CameraMessage.8b20698258a5e70e"
NSRM_ASSERT(sizeof(nsrm_camera_message) == 52, "size of nsrm_camera_message");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_camera_message) == 4, "alignment of nsrm_camera_message");
NSRM_ASSERT(offsetof(nsrm_camera_message, width) == 0, "offset of width");
NSRM_ASSERT(offsetof(nsrm_camera_message, height) == 4, "offset of height");
NSRM_ASSERT(offsetof(nsrm_camera_message, fx) == 8, "offset of fx");
NSRM_ASSERT(offsetof(nsrm_camera_message, fy) == 12, "offset of fy");
NSRM_ASSERT(offsetof(nsrm_camera_message, cx) == 16, "offset of cx");
NSRM_ASSERT(offsetof(nsrm_camera_message, cy) == 20, "offset of cy");
NSRM_ASSERT(offsetof(nsrm_camera_message, position) == 24, "offset of position");
NSRM_ASSERT(offsetof(nsrm_camera_message, orientation) == 36, "offset of orientation");

/** An object that a detector has found in an image. */
typedef struct nsrm_detected_box {
    /** Id of the object, the same in all frames; not zero. */
    uint32_t id;
    /** 0 if it is completely visible, 1 if others are known to hide part of it, 2 if they hide
     *  all of it: it then keeps its earlier appearance, and without one it is left out. */
    uint32_t covered;
    /** Corners x1, y1, x2, y2 of the box around its visible part, as fractions of the image's
     *  width and height. */
    float visible[4];
    /** Corners of the box around the whole object, including hidden parts as far as they are
     *  known, then the mean depth of its pixels along the optical axis, metres. */
    float location[5];
} nsrm_detected_box;
#define NSRM_DETECTED_BOX_TYPE_NAME "nsrm.v1.DetectedBox.a804d86f803d6e69"
NSRM_ASSERT(sizeof(nsrm_detected_box) == 44, "size of nsrm_detected_box");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_detected_box) == 4, "alignment of nsrm_detected_box");
NSRM_ASSERT(offsetof(nsrm_detected_box, id) == 0, "offset of id");
NSRM_ASSERT(offsetof(nsrm_detected_box, covered) == 4, "offset of covered");
NSRM_ASSERT(offsetof(nsrm_detected_box, visible) == 8, "offset of visible");
NSRM_ASSERT(offsetof(nsrm_detected_box, location) == 24, "offset of location");

/** Header of a frame (service `camera`); the bytes of the image follow as a slice: first the
 *  RGB rows, then the depth rows, both without gaps.
 *
 *  RGB: three bytes per pixel. Depth: one little-endian `f32` per pixel, metres along the
 *  optical axis, 0 for no measurement. */
typedef struct nsrm_camera_frame {
    /** Sequence number: increases with each frame of one publisher. */
    uint64_t sequence;
    /** When the image was taken, nanoseconds on the publisher's clock. */
    uint64_t timestamp_ns;
    /** The camera. */
    nsrm_camera_message camera;
    /** The number of valid entries in `boxes`. */
    uint32_t count;
    /** The detections. */
    nsrm_detected_box boxes[16];
} nsrm_camera_frame;
#define NSRM_CAMERA_FRAME_TYPE_NAME "nsrm.v1.CameraFrame.5791200141f197a9"
NSRM_ASSERT(sizeof(nsrm_camera_frame) == 776, "size of nsrm_camera_frame");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_camera_frame) == 8, "alignment of nsrm_camera_frame");
NSRM_ASSERT(offsetof(nsrm_camera_frame, sequence) == 0, "offset of sequence");
NSRM_ASSERT(offsetof(nsrm_camera_frame, timestamp_ns) == 8, "offset of timestamp_ns");
NSRM_ASSERT(offsetof(nsrm_camera_frame, camera) == 16, "offset of camera");
NSRM_ASSERT(offsetof(nsrm_camera_frame, count) == 68, "offset of count");
NSRM_ASSERT(offsetof(nsrm_camera_frame, boxes) == 72, "offset of boxes");

/** An object in the camera's view. */
typedef struct nsrm_object_message {
    /** Id of the object, the same in all scenes; not zero. */
    uint32_t id;
    /** Box corners x1, y1, x2, y2 as fractions of the image's width and
     *  height, then mean depth in metres. */
    float location[5];
    /** The crop encoder's embedding. */
    float embedding[64];
} nsrm_object_message;
#define NSRM_OBJECT_MESSAGE_TYPE_NAME "nsrm.v1.ObjectMessage.74f496911c7af3de"
NSRM_ASSERT(sizeof(nsrm_object_message) == 280, "size of nsrm_object_message");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_object_message) == 4, "alignment of nsrm_object_message");
NSRM_ASSERT(offsetof(nsrm_object_message, id) == 0, "offset of id");
NSRM_ASSERT(offsetof(nsrm_object_message, location) == 4, "offset of location");
NSRM_ASSERT(offsetof(nsrm_object_message, embedding) == 24, "offset of embedding");

/** The latest scene (service `scene`). Has the same bytes as core's `RawScene`;
 *  `SceneMessage::to_scene` checks them. */
typedef struct nsrm_scene_message {
    /** Version of this layout: `nsrm_core::scene::SCENE_SCHEMA`. */
    uint32_t schema;
    /** Frame of reference of the camera's pose. */
    uint32_t frame;
    /** Tag of the model whose encoder computed the embeddings. */
    uint64_t model_tag;
    /** Sequence number: increases with each scene of one publisher. */
    uint64_t sequence;
    /** When the image was taken, nanoseconds on the publisher's clock. */
    uint64_t timestamp_ns;
    /** The camera. */
    nsrm_camera_message camera;
    /** The number of valid entries in `objects`. */
    uint32_t count;
    /** The objects. */
    nsrm_object_message objects[16];
} nsrm_scene_message;
#define NSRM_SCENE_MESSAGE_TYPE_NAME "nsrm.v1.SceneMessage.44a4c1a31d84fbc0"
NSRM_ASSERT(sizeof(nsrm_scene_message) == 4568, "size of nsrm_scene_message");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_scene_message) == 8, "alignment of nsrm_scene_message");
NSRM_ASSERT(offsetof(nsrm_scene_message, schema) == 0, "offset of schema");
NSRM_ASSERT(offsetof(nsrm_scene_message, frame) == 4, "offset of frame");
NSRM_ASSERT(offsetof(nsrm_scene_message, model_tag) == 8, "offset of model_tag");
NSRM_ASSERT(offsetof(nsrm_scene_message, sequence) == 16, "offset of sequence");
NSRM_ASSERT(offsetof(nsrm_scene_message, timestamp_ns) == 24, "offset of timestamp_ns");
NSRM_ASSERT(offsetof(nsrm_scene_message, camera) == 32, "offset of camera");
NSRM_ASSERT(offsetof(nsrm_scene_message, count) == 84, "offset of count");
NSRM_ASSERT(offsetof(nsrm_scene_message, objects) == 88, "offset of objects");

/** A request to execute a sentence, or to cancel one. */
typedef struct nsrm_plan_request {
    /** The client: a unique number. */
    uint64_t client;
    /** Number of the request, the client's own. */
    uint64_t sequence;
    /** What is requested: the number of a `Purpose`. */
    uint32_t purpose;
    /** Bytes of the sentence; 0 to cancel. */
    uint32_t sentence_length;
    /** The sentence in UTF-8. */
    uint8_t sentence[4096];
} nsrm_plan_request;
#define NSRM_PLAN_REQUEST_TYPE_NAME "nsrm.v1.PlanRequest.912596fd2fc37f48"
NSRM_ASSERT(sizeof(nsrm_plan_request) == 4120, "size of nsrm_plan_request");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_plan_request) == 8, "alignment of nsrm_plan_request");
NSRM_ASSERT(offsetof(nsrm_plan_request, client) == 0, "offset of client");
NSRM_ASSERT(offsetof(nsrm_plan_request, sequence) == 8, "offset of sequence");
NSRM_ASSERT(offsetof(nsrm_plan_request, purpose) == 16, "offset of purpose");
NSRM_ASSERT(offsetof(nsrm_plan_request, sentence_length) == 20, "offset of sentence_length");
NSRM_ASSERT(offsetof(nsrm_plan_request, sentence) == 24, "offset of sentence");

/** A relation in a description: to what, and where this lies from it. */
typedef struct nsrm_relation_message {
    /** 0: the state that an action brings about; 1: nearest; 2: farthest; 3: none, a further
     *  reference of what is between two. */
    uint32_t kind;
    /** Index of that action in the model; 0 for the other kinds. */
    uint32_t action;
    /** How many concepts describe the other object. */
    uint32_t count;
    /** Those concepts: indices in the model; 0 after the last. */
    uint8_t concepts[4];
    /** Which of several such objects: 0 if that is left open, 1 for the largest, 2 for the
     *  smallest, or 3 plus the index of the action in whose direction it lies farthest. */
    uint32_t which;
} nsrm_relation_message;
#define NSRM_RELATION_MESSAGE_TYPE_NAME "nsrm.v1.RelationMessage.c033a237e5f05959"
NSRM_ASSERT(sizeof(nsrm_relation_message) == 20, "size of nsrm_relation_message");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_relation_message) == 4, "alignment of nsrm_relation_message");
NSRM_ASSERT(offsetof(nsrm_relation_message, kind) == 0, "offset of kind");
NSRM_ASSERT(offsetof(nsrm_relation_message, action) == 4, "offset of action");
NSRM_ASSERT(offsetof(nsrm_relation_message, count) == 8, "offset of count");
NSRM_ASSERT(offsetof(nsrm_relation_message, concepts) == 12, "offset of concepts");
NSRM_ASSERT(offsetof(nsrm_relation_message, which) == 16, "offset of which");

/** A step as parsed and, if it is still to be done, as grounded. */
typedef struct nsrm_step_message {
    /** Index of the action in the model. */
    uint32_t action;
    /** How many concepts describe the object to move. */
    uint32_t object_count;
    /** Those concepts: indices in the model; 0 after the last. */
    uint8_t object[4];
    /** Which of several such objects is moved, as in a relation. */
    uint32_t object_which;
    /** How many concepts describe objects that are not moved though all else fits; 0 if none is
     *  left out. */
    uint32_t object_except_count;
    /** Those concepts. */
    uint8_t object_except[4];
    /** Whether a single such object is left out, 0, or any number, as which of several. */
    uint32_t object_except_which;
    /** How many relations the description of the object to move has. */
    uint32_t object_relation_count;
    /** Those relations: its own to another object, then that one's to a third; all 0 after the
     *  last. */
    nsrm_relation_message object_relations[2];
    /** How many concepts describe the reference. */
    uint32_t reference_count;
    /** Those concepts. */
    uint8_t reference[4];
    /** Which of several such objects is the reference, as in a relation. */
    uint32_t reference_which;
    /** How many concepts describe objects that are not the reference though all else fits. */
    uint32_t reference_except_count;
    /** Those concepts. */
    uint8_t reference_except[4];
    /** Whether a single such object is left out, 0, or any number. */
    uint32_t reference_except_which;
    /** How many relations the description of the reference has. */
    uint32_t reference_relation_count;
    /** Those relations. */
    nsrm_relation_message reference_relations[2];
    /** The distance between the faces of the two, or by which the object is moved from where it
     *  is, millimetres; 0 where the sentence names none. */
    uint32_t distance_mm;
    /** Id of the object to move; 0 if the step is not grounded, and then all fields below are
     *  0. */
    uint32_t object_id;
    /** Id of the reference; of the table, that of the object beside which there is room; of the
     *  object itself, its own. */
    uint32_t reference_id;
    /** How well the object fits its description, a cosine. */
    float object_score;
    /** How well the reference fits. */
    float reference_score;
    /** Probability of each choice: split, acceptable words, action, relations between the words,
     *  words of the object, words of the reference, object, reference. */
    float confidence[8];
    /** Sub-goal position of the object's centre: world frame, metres. */
    float position[3];
    /** Sub-goal orientation, world frame: x, y, z, w. */
    float orientation[4];
    /** Predicted location in the image: x1, y1, x2, y2 as fractions of the image, mean depth in
     *  metres. */
    float location[5];
} nsrm_step_message;
#define NSRM_STEP_MESSAGE_TYPE_NAME "nsrm.v1.StepMessage.cf0090730a3b4daa"
NSRM_ASSERT(sizeof(nsrm_step_message) == 240, "size of nsrm_step_message");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_step_message) == 4, "alignment of nsrm_step_message");
NSRM_ASSERT(offsetof(nsrm_step_message, action) == 0, "offset of action");
NSRM_ASSERT(offsetof(nsrm_step_message, object_count) == 4, "offset of object_count");
NSRM_ASSERT(offsetof(nsrm_step_message, object) == 8, "offset of object");
NSRM_ASSERT(offsetof(nsrm_step_message, object_which) == 12, "offset of object_which");
NSRM_ASSERT(offsetof(nsrm_step_message, object_except_count) == 16, "offset of object_except_count");
NSRM_ASSERT(offsetof(nsrm_step_message, object_except) == 20, "offset of object_except");
NSRM_ASSERT(offsetof(nsrm_step_message, object_except_which) == 24, "offset of object_except_which");
NSRM_ASSERT(offsetof(nsrm_step_message, object_relation_count) == 28, "offset of object_relation_count");
NSRM_ASSERT(offsetof(nsrm_step_message, object_relations) == 32, "offset of object_relations");
NSRM_ASSERT(offsetof(nsrm_step_message, reference_count) == 72, "offset of reference_count");
NSRM_ASSERT(offsetof(nsrm_step_message, reference) == 76, "offset of reference");
NSRM_ASSERT(offsetof(nsrm_step_message, reference_which) == 80, "offset of reference_which");
NSRM_ASSERT(offsetof(nsrm_step_message, reference_except_count) == 84, "offset of reference_except_count");
NSRM_ASSERT(offsetof(nsrm_step_message, reference_except) == 88, "offset of reference_except");
NSRM_ASSERT(offsetof(nsrm_step_message, reference_except_which) == 92, "offset of reference_except_which");
NSRM_ASSERT(offsetof(nsrm_step_message, reference_relation_count) == 96, "offset of reference_relation_count");
NSRM_ASSERT(offsetof(nsrm_step_message, reference_relations) == 100, "offset of reference_relations");
NSRM_ASSERT(offsetof(nsrm_step_message, distance_mm) == 140, "offset of distance_mm");
NSRM_ASSERT(offsetof(nsrm_step_message, object_id) == 144, "offset of object_id");
NSRM_ASSERT(offsetof(nsrm_step_message, reference_id) == 148, "offset of reference_id");
NSRM_ASSERT(offsetof(nsrm_step_message, object_score) == 152, "offset of object_score");
NSRM_ASSERT(offsetof(nsrm_step_message, reference_score) == 156, "offset of reference_score");
NSRM_ASSERT(offsetof(nsrm_step_message, confidence) == 160, "offset of confidence");
NSRM_ASSERT(offsetof(nsrm_step_message, position) == 192, "offset of position");
NSRM_ASSERT(offsetof(nsrm_step_message, orientation) == 204, "offset of orientation");
NSRM_ASSERT(offsetof(nsrm_step_message, location) == 220, "offset of location");

/** An event in the execution of a `PlanRequest`. */
typedef struct nsrm_plan_reply {
    /** The client. */
    uint64_t client;
    /** Number of the request. */
    uint64_t request;
    /** Number of the plan; 0 if there is none. */
    uint64_t plan;
    /** Number of the reply to its request, from 1: a gap is a loss. */
    uint32_t number;
    /** The event: the number of a `Status`. */
    uint32_t status;
    /** Which step it is about, from 0. */
    uint32_t step;
    /** How many steps the program has; at least 1 with `Status::Planned`, else 0. */
    uint32_t count;
    /** Why it failed: place in `REASONS` from 1; 0 if it did not fail. */
    uint32_t reason;
    /** How far from its sub-goal an object was observed, metres. */
    float off_m;
    /** Bytes of the message. */
    uint32_t message_length;
    /** Always 0. */
    uint32_t reserved;
    /** Text for a person, UTF-8: the program in the paper's notation with `Status::Planned`,
     *  and a line for each misspelt word that says what it was read as; else the reason. */
    uint8_t message[1024];
    /** The program's steps with `Status::Planned`. */
    nsrm_step_message steps[8];
} nsrm_plan_reply;
#define NSRM_PLAN_REPLY_TYPE_NAME "nsrm.v1.PlanReply.a2af30d8382126dc"
NSRM_ASSERT(sizeof(nsrm_plan_reply) == 3000, "size of nsrm_plan_reply");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_plan_reply) == 8, "alignment of nsrm_plan_reply");
NSRM_ASSERT(offsetof(nsrm_plan_reply, client) == 0, "offset of client");
NSRM_ASSERT(offsetof(nsrm_plan_reply, request) == 8, "offset of request");
NSRM_ASSERT(offsetof(nsrm_plan_reply, plan) == 16, "offset of plan");
NSRM_ASSERT(offsetof(nsrm_plan_reply, number) == 24, "offset of number");
NSRM_ASSERT(offsetof(nsrm_plan_reply, status) == 28, "offset of status");
NSRM_ASSERT(offsetof(nsrm_plan_reply, step) == 32, "offset of step");
NSRM_ASSERT(offsetof(nsrm_plan_reply, count) == 36, "offset of count");
NSRM_ASSERT(offsetof(nsrm_plan_reply, reason) == 40, "offset of reason");
NSRM_ASSERT(offsetof(nsrm_plan_reply, off_m) == 44, "offset of off_m");
NSRM_ASSERT(offsetof(nsrm_plan_reply, message_length) == 48, "offset of message_length");
NSRM_ASSERT(offsetof(nsrm_plan_reply, reserved) == 52, "offset of reserved");
NSRM_ASSERT(offsetof(nsrm_plan_reply, message) == 56, "offset of message");
NSRM_ASSERT(offsetof(nsrm_plan_reply, steps) == 1080, "offset of steps");

/** A command (service `sub_goal`): move an object to its sub-goal, or stop doing so. Each is
 *  acknowledged by a `crate::message::Feedback`; a repeated command gets the same answer and
 *  is not executed again.
 *
 *  A delayed controller may read commands that are obsolete. Of all waiting commands it obeys
 *  stops first. It answers, but does not execute, a command that it reads after `until_ns`, or
 *  that is older than one it has received (with a smaller plan number, or with the same one and
 *  a smaller command number). */
typedef struct nsrm_sub_goal {
    /** Number of the plan; a later plan has a greater number. */
    uint64_t plan;
    /** The deadline for starting it, nanoseconds on the clock of the robot's processes: the
     *  machine's monotonic clock, or the wall clock on several hosts. Then the planner abandons
     *  it. 0 for a stop, which is never too late. */
    uint64_t until_ns;
    /** Number of the command within its plan, from 1; a stop has the number of the command that
     *  it stops. */
    uint32_t command;
    /** The number of a `Kind`; in a stop all fields below are 0. */
    uint32_t kind;
    /** Number of the step, from 0. */
    uint32_t step;
    /** Number of steps in the program. */
    uint32_t steps;
    /** Index of the action in the model. */
    uint32_t action;
    /** Id of the object to move. */
    uint32_t object_id;
    /** Id of the reference object; of the table, of the object beside which there is room; of the
     *  object itself, its own. */
    uint32_t reference_id;
    /** Product of the step's probabilities, 0 to 1. */
    float confidence;
    /** Sub-goal position of the object's centre: world frame, metres. */
    float position[3];
    /** Sub-goal orientation, world frame: x, y, z, w. */
    float orientation[4];
    /** Predicted location in the image: x1, y1, x2, y2 as fractions of the image, mean depth in
     *  metres. */
    float location[5];
    /** Ids of objects that must stay where they are, besides the reference: the objects and
     *  references of completed steps; 0 for none. */
    uint32_t keep[16];
} nsrm_sub_goal;
#define NSRM_SUB_GOAL_TYPE_NAME "nsrm.v1.SubGoal.027c01d730571850"
NSRM_ASSERT(sizeof(nsrm_sub_goal) == 160, "size of nsrm_sub_goal");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_sub_goal) == 8, "alignment of nsrm_sub_goal");
NSRM_ASSERT(offsetof(nsrm_sub_goal, plan) == 0, "offset of plan");
NSRM_ASSERT(offsetof(nsrm_sub_goal, until_ns) == 8, "offset of until_ns");
NSRM_ASSERT(offsetof(nsrm_sub_goal, command) == 16, "offset of command");
NSRM_ASSERT(offsetof(nsrm_sub_goal, kind) == 20, "offset of kind");
NSRM_ASSERT(offsetof(nsrm_sub_goal, step) == 24, "offset of step");
NSRM_ASSERT(offsetof(nsrm_sub_goal, steps) == 28, "offset of steps");
NSRM_ASSERT(offsetof(nsrm_sub_goal, action) == 32, "offset of action");
NSRM_ASSERT(offsetof(nsrm_sub_goal, object_id) == 36, "offset of object_id");
NSRM_ASSERT(offsetof(nsrm_sub_goal, reference_id) == 40, "offset of reference_id");
NSRM_ASSERT(offsetof(nsrm_sub_goal, confidence) == 44, "offset of confidence");
NSRM_ASSERT(offsetof(nsrm_sub_goal, position) == 48, "offset of position");
NSRM_ASSERT(offsetof(nsrm_sub_goal, orientation) == 60, "offset of orientation");
NSRM_ASSERT(offsetof(nsrm_sub_goal, location) == 76, "offset of location");
NSRM_ASSERT(offsetof(nsrm_sub_goal, keep) == 96, "offset of keep");

/** The outcome of a command (service `feedback`). */
typedef struct nsrm_feedback {
    /** Number of the plan, as in `crate::message::SubGoal::plan`. */
    uint64_t plan;
    /** Counts up with each feedback of one controller: a gap is a loss. */
    uint64_t sequence;
    /** When the outcome occurred, nanoseconds on the sender's clock. */
    uint64_t timestamp_ns;
    /** Number of the command, as in `crate::message::SubGoal::command`. */
    uint32_t command;
    /** The number of an `Outcome`. */
    uint32_t outcome;
    /** Ids of up to two objects: those in the way, or for `Outcome::Clearing` those that
     *  are moved aside; 0 for none. */
    uint32_t objects[2];
} nsrm_feedback;
#define NSRM_FEEDBACK_TYPE_NAME "nsrm.v1.Feedback.343e85d0c8daab6b"
NSRM_ASSERT(sizeof(nsrm_feedback) == 40, "size of nsrm_feedback");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_feedback) == 8, "alignment of nsrm_feedback");
NSRM_ASSERT(offsetof(nsrm_feedback, plan) == 0, "offset of plan");
NSRM_ASSERT(offsetof(nsrm_feedback, sequence) == 8, "offset of sequence");
NSRM_ASSERT(offsetof(nsrm_feedback, timestamp_ns) == 16, "offset of timestamp_ns");
NSRM_ASSERT(offsetof(nsrm_feedback, command) == 24, "offset of command");
NSRM_ASSERT(offsetof(nsrm_feedback, outcome) == 28, "offset of outcome");
NSRM_ASSERT(offsetof(nsrm_feedback, objects) == 32, "offset of objects");

/** A heartbeat (service `heartbeat`). */
typedef struct nsrm_heartbeat {
    /** Sequence number: increases with each heartbeat of one node. */
    uint64_t sequence;
    /** When it was sent, nanoseconds on the sender's clock. */
    uint64_t timestamp_ns;
    /** When the node was started: distinguishes it from a later one in its place. */
    uint64_t started_ns;
    /** How many messages it has rejected since then, because they were invalid or too late. */
    uint64_t rejected;
    /** The sender's role: the number of a `Role`. */
    uint32_t role;
    /** The sender's state: the number of a `State`. */
    uint32_t state;
} nsrm_heartbeat;
#define NSRM_HEARTBEAT_TYPE_NAME "nsrm.v1.Heartbeat.6f9d992f9581fe82"
NSRM_ASSERT(sizeof(nsrm_heartbeat) == 40, "size of nsrm_heartbeat");
NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_heartbeat) == 8, "alignment of nsrm_heartbeat");
NSRM_ASSERT(offsetof(nsrm_heartbeat, sequence) == 0, "offset of sequence");
NSRM_ASSERT(offsetof(nsrm_heartbeat, timestamp_ns) == 8, "offset of timestamp_ns");
NSRM_ASSERT(offsetof(nsrm_heartbeat, started_ns) == 16, "offset of started_ns");
NSRM_ASSERT(offsetof(nsrm_heartbeat, rejected) == 24, "offset of rejected");
NSRM_ASSERT(offsetof(nsrm_heartbeat, role) == 32, "offset of role");
NSRM_ASSERT(offsetof(nsrm_heartbeat, state) == 36, "offset of state");

/** Values of `PlanRequest.purpose`. */
enum nsrm_purpose {
    /** Plan only. */
    NSRM_PURPOSE_PLAN_ONLY = 1,
    /** Execute, and observe the scene after each step. */
    NSRM_PURPOSE_CLOSED_LOOP = 2,
    /** Execute without observing. */
    NSRM_PURPOSE_OPEN_LOOP = 3,
    /** Cancel the request with this number. */
    NSRM_PURPOSE_CANCEL = 4,
};

/** Values of `PlanReply.status`. */
enum nsrm_status {
    /** It was parsed and grounded; repeated before each step that is grounded again. */
    NSRM_STATUS_PLANNED = 1,
    /** A step was sent to the controller. */
    NSRM_STATUS_COMMANDED = 2,
    /** A step succeeded. */
    NSRM_STATUS_REACHED = 3,
    /** A step failed and is retried. */
    NSRM_STATUS_AGAIN = 4,
    /** The sentence is done. The last reply. */
    NSRM_STATUS_DONE = 5,
    /** The request was refused or has failed. The last reply. */
    NSRM_STATUS_FAILED = 6,
    /** Other objects are moved aside before a step's object is moved. */
    NSRM_STATUS_CLEARING = 7,
};

/** Values of `SubGoal.kind`. */
enum nsrm_kind {
    /** Move the object to its sub-goal. */
    NSRM_KIND_MOVE = 1,
    /** Stop. */
    NSRM_KIND_STOP = 2,
};

/** Values of `Feedback.outcome`. */
enum nsrm_outcome {
    /** It will be executed; another outcome follows. */
    NSRM_OUTCOME_ACCEPTED = 1,
    /** The object is at its sub-goal. */
    NSRM_OUTCOME_REACHED = 2,
    /** No space at the sub-goal, or no collision-free path. */
    NSRM_OUTCOME_NO_PATH = 3,
    /** The gripper did not grasp the object. */
    NSRM_OUTCOME_NOT_GRASPED = 4,
    /** The object was dropped on the way. */
    NSRM_OUTCOME_DROPPED = 5,
    /** Placed, but not at its sub-goal. */
    NSRM_OUTCOME_MISPLACED = 6,
    /** Stopped by a command, a person or a safety function. */
    NSRM_OUTCOME_STOPPED = 7,
    /** Another command is being executed; this one won't be. */
    NSRM_OUTCOME_BUSY = 8,
    /** The command is invalid, or its object isn't visible; it won't be executed. */
    NSRM_OUTCOME_IMPOSSIBLE = 9,
    /** It was read after its deadline; it won't be executed. */
    NSRM_OUTCOME_TOO_LATE = 10,
    /** Nothing supports the object at its sub-goal, or it would fall there. */
    NSRM_OUTCOME_WOULD_FALL = 11,
    /** The object or its sub-goal is out of the arm's reach. */
    NSRM_OUTCOME_OUT_OF_REACH = 12,
    /** The arm's joints do not follow their commands; the arm has stopped. */
    NSRM_OUTCOME_NOT_FOLLOWING = 13,
    /** Another object stands on the object. */
    NSRM_OUTCOME_COVERED = 14,
    /** The gripper cannot hold an object of this size. */
    NSRM_OUTCOME_CANNOT_HOLD = 15,
    /** Other objects are moved aside first, or the object itself is regrasped on the way;
     *  another outcome follows. */
    NSRM_OUTCOME_CLEARING = 16,
    /** The reference object was moved after the command was sent; the object was not
     *  grasped. */
    NSRM_OUTCOME_REFERENCE_MOVED = 17,
};

/** Values of `Heartbeat.role`. */
enum nsrm_role {
    /** Publishes camera frames. */
    NSRM_ROLE_CAMERA = 1,
    /** Turns frames into scenes. */
    NSRM_ROLE_PERCEPTION = 2,
    /** Answers sentences with plans. */
    NSRM_ROLE_PLANNER = 3,
    /** Executes sub-goals. */
    NSRM_ROLE_CONTROLLER = 4,
    /** Sends sentences to the planner. */
    NSRM_ROLE_CLIENT = 5,
    /** Observes. */
    NSRM_ROLE_WATCHER = 6,
};

/** Values of `Heartbeat.state`. */
enum nsrm_state {
    /** Not yet ready. */
    NSRM_STATE_STARTING = 1,
    /** Ready and idle. */
    NSRM_STATE_IDLE = 2,
    /** Working. */
    NSRM_STATE_BUSY = 3,
    /** Alive, but unable to work; needs a person. */
    NSRM_STATE_FAILED = 4,
};

/** Values of `PlanReply.reason`. */
enum nsrm_reason {
    NSRM_REASON_NO_WORDS = 1,
    NSRM_REASON_UNKNOWN_WORD = 2,
    NSRM_REASON_SENTENCE_TOO_LONG = 3,
    NSRM_REASON_TOO_MANY_CONCEPTS = 4,
    NSRM_REASON_TOO_MANY_STEPS = 5,
    NSRM_REASON_TOO_MANY_REFERENCES = 6,
    NSRM_REASON_INCOMPLETE_STEP = 7,
    NSRM_REASON_SAME_REFERENCE = 8,
    NSRM_REASON_UNSURE = 9,
    NSRM_REASON_NO_SUCH_OBJECT = 10,
    NSRM_REASON_AMBIGUOUS = 11,
    NSRM_REASON_SAME_OBJECT = 12,
    NSRM_REASON_NOT_FINITE = 13,
    NSRM_REASON_OUTSIDE_WORK_SPACE = 14,
    NSRM_REASON_OTHER_MODEL = 15,
    NSRM_REASON_INVALID_MODEL = 16,
    NSRM_REASON_NO_SCENE = 17,
    NSRM_REASON_NOT_ACCEPTED = 18,
    NSRM_REASON_NO_OUTCOME = 19,
    NSRM_REASON_CONTROLLER_LOST = 20,
    NSRM_REASON_UNSUCCESSFUL = 21,
    NSRM_REASON_NOT_THERE = 22,
    NSRM_REASON_NOT_SEEN = 23,
    NSRM_REASON_CANCELLED = 24,
    NSRM_REASON_CANCELLED_UNCONFIRMED = 25,
    NSRM_REASON_BUSY = 26,
    NSRM_REASON_BAD_REQUEST = 27,
    NSRM_REASON_NO_SUCH_REQUEST = 28,
    NSRM_REASON_STOPPING = 29,
    NSRM_REASON_UNANSWERED = 30,
    NSRM_REASON_CLOCK_SET_BACK = 31,
    NSRM_REASON_CONFLICTING_VALUES = 32,
    NSRM_REASON_CALIBRATION = 33,
    NSRM_REASON_PARSED_BY_OTHER_MODEL = 34,
    NSRM_REASON_LOW_CONFIDENCE = 35,
    NSRM_REASON_UNCLEAR_WORDS = 36,
    NSRM_REASON_TOO_MANY_RELATIONS = 37,
    NSRM_REASON_OUTSIDE_TRAINING_VIEW = 38,
    NSRM_REASON_OTHER_OBJECT = 39,
    NSRM_REASON_UNCLEAR_PRONOUN = 40,
    NSRM_REASON_SEVERAL_REFERENCES = 41,
    NSRM_REASON_OTHER_NUMBER = 42,
    NSRM_REASON_ONLY_ON_TABLE = 43,
    NSRM_REASON_ALREADY_ON_TABLE = 44,
    NSRM_REASON_NO_ROOM_ON_TABLE = 45,
    NSRM_REASON_HIDDEN_REFERENCE = 46,
    NSRM_REASON_NOT_ON_TABLE = 47,
    NSRM_REASON_OTHER = 48,
};

/* The publish-subscribe services `nsrm/v1/<robot>/<service>`, and the settings to open them with:
 * how many messages wait for a subscriber; how many a late subscriber gets; whether a full buffer
 * drops the oldest; the numbers of publishers and subscribers. */
#define NSRM_CAMERA_SERVICE "camera"
#define NSRM_CAMERA_BUFFER 1
#define NSRM_CAMERA_HISTORY 1
#define NSRM_CAMERA_OVERFLOW 1
#define NSRM_CAMERA_PUBLISHERS 1
#define NSRM_CAMERA_SUBSCRIBERS 16
#define NSRM_SCENE_SERVICE "scene"
#define NSRM_SCENE_BUFFER 1
#define NSRM_SCENE_HISTORY 1
#define NSRM_SCENE_OVERFLOW 1
#define NSRM_SCENE_PUBLISHERS 1
#define NSRM_SCENE_SUBSCRIBERS 16
#define NSRM_SUB_GOAL_SERVICE "sub_goal"
#define NSRM_SUB_GOAL_BUFFER 8
#define NSRM_SUB_GOAL_HISTORY 0
#define NSRM_SUB_GOAL_OVERFLOW 0
#define NSRM_SUB_GOAL_PUBLISHERS 1
#define NSRM_SUB_GOAL_SUBSCRIBERS 1
#define NSRM_FEEDBACK_SERVICE "feedback"
#define NSRM_FEEDBACK_BUFFER 64
#define NSRM_FEEDBACK_HISTORY 0
#define NSRM_FEEDBACK_OVERFLOW 1
#define NSRM_FEEDBACK_PUBLISHERS 1
#define NSRM_FEEDBACK_SUBSCRIBERS 16
#define NSRM_HEARTBEAT_SERVICE "heartbeat"
#define NSRM_HEARTBEAT_BUFFER 16
#define NSRM_HEARTBEAT_HISTORY 0
#define NSRM_HEARTBEAT_OVERFLOW 1
#define NSRM_HEARTBEAT_PUBLISHERS 16
#define NSRM_HEARTBEAT_SUBSCRIBERS 16

#endif /* NSRM_MESSAGES_H */
