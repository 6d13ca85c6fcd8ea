/* The C interface of NSRM: a sentence and an observed scene in; a program and its sub-goals out.
 * Written from the crate by `cargo run -p nsrm-c --example header`; do not edit.
 * SPDX-License-Identifier: Apache-2.0 */

#ifndef NSRM_H
#define NSRM_H

#include <stddef.h>
#include <stdint.h>

/** Objects in a scene. */
#define NSRM_MAX_OBJECTS 16

/** Steps in a program. */
#define NSRM_MAX_STEPS 8

/** Attribute values that describe one object. */
#define NSRM_MAX_FILTERS 4

/** Relations in one description. */
#define NSRM_MAX_RELATIONS 2

/** Misspelt words of a sentence that are read as others. */
#define NSRM_MAX_CORRECTIONS 4

/** Candidates that are listed where several objects fit. */
#define NSRM_MAX_CANDIDATES 8

/** Bytes in a sentence. */
#define NSRM_MAX_SENTENCE_BYTES 4096

/** Calls of `nsrm_poll` until it is done, at most. */
#define NSRM_MAX_POLLS 157209

/** Numbers in an object's embedding. */
#define NSRM_EMBEDDING 64

/** Bytes of an observer. */
#define NSRM_OBSERVER_BYTES 17408

/** `which`: the one of the largest volume. */
#define NSRM_LARGEST 1

/** `which`: the one of the smallest volume. */
#define NSRM_SMALLEST 2

/**
 * `which`: with the index of an action added, the one that lies farthest in the direction in which the
 * action puts things.
 */
#define NSRM_FARTHEST_BY 3

/** `which`: all that fit, apart from the reference; only of what is moved. */
#define NSRM_ALL 512

/** `which`: all that fit, which are two; only of what is moved. */
#define NSRM_BOTH 513

/**
 * `which`: one of several that are moved. Once a step with `NSRM_ALL` or `NSRM_BOTH` is grounded, it is
 * replaced by one of these for each object.
 */
#define NSRM_EACH 514

/** `which`: the table, and no object. */
#define NSRM_TABLE 515

/** `which`: the object that is moved, from where it is; of several that are moved, each other one. */
#define ITSELF 516

/**
 * `which`: with an index of `nsrm_ranked_name` added, what is counted from the farthest, the largest or the
 * smallest one, "the second from the left".
 */
#define NSRM_RANKED 1024

/** Bytes of a task. */
#define NSRM_TASK_BYTES 15744

/** What a function returns: not negative if it did what it says. */
enum nsrm_status_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /** Done. */
    NSRM_OK = 0,
    /** More calls of `nsrm_poll` are needed. */
    NSRM_PENDING = 1,
    /** The sentence is refused; `nsrm_refusal_message` says why. */
    NSRM_REFUSED = 2,
    /** The scene or the image is invalid; `nsrm_refusal_message` or `nsrm_observer_message` says why. */
    NSRM_INVALID_INPUT = 3,
    /** The text did not fit and was cut: it takes as many bytes as was written to `needed`. */
    NSRM_TRUNCATED = 4,
    /** A pointer is null. */
    NSRM_ERROR_NULL = -1,
    /** A pointer is not aligned as its type must be. */
    NSRM_ERROR_MISALIGNED = -2,
    /** A text is not UTF-8. */
    NSRM_ERROR_NOT_UTF8 = -3,
    /** A struct's `size` is not that of this library's header: header and library differ. */
    NSRM_ERROR_STRUCT_SIZE = -4,
    /** Nothing was begun in this memory, or what was begun has another result. */
    NSRM_ERROR_NOT_BEGUN = -5,
    /** Another call uses this memory at the moment. */
    NSRM_ERROR_BUSY = -6,
    /** It is not done: call `nsrm_poll` until it no longer returns `NSRM_PENDING`. */
    NSRM_ERROR_NOT_DONE = -7,
    /** This is not a model. */
    NSRM_ERROR_NOT_A_MODEL = -8,
    /** An index is greater than the last one. */
    NSRM_ERROR_INDEX = -9,
    /** A size or a count is greater than its limit. */
    NSRM_ERROR_TOO_LARGE = -10,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum nsrm_status_t nsrm_status_t;
#else
typedef int32_t nsrm_status_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/** Whether a word names a value, an extreme, a number of objects or the table. */
enum nsrm_property_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /** What an object looks like, "red". */
    NSRM_PROPERTY_CONCEPT = 0,
    /** Which one of several it is, "leftmost". */
    NSRM_PROPERTY_EXTREME = 1,
    /** That several are meant, "all". */
    NSRM_PROPERTY_QUANTIFIER = 2,
    /** That it is the table, and no object. */
    NSRM_PROPERTY_TABLE = 3,
    /** That it is the object that is moved; no word says so. */
    NSRM_PROPERTY_ITSELF = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum nsrm_property_kind_t nsrm_property_kind_t;
#else
typedef uint32_t nsrm_property_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Why a sentence is refused. Later versions append theirs: treat an unknown one as a refusal, and
 * report it by its message.
 */
enum nsrm_refusal_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /** The sentence has no words. */
    NSRM_REFUSAL_NO_WORDS = 1,
    /** A word that the model was not trained on: `span`. */
    NSRM_REFUSAL_UNKNOWN_WORD = 2,
    /** The sentence is longer than `limit`; `detail` is the unit. */
    NSRM_REFUSAL_SENTENCE_TOO_LONG = 3,
    /** More adjacent attribute values than `limit`: `span`. */
    NSRM_REFUSAL_TOO_MANY_CONCEPTS = 4,
    /** Two values of one attribute, such as two colours, or two extremes: `span`, `values`. */
    NSRM_REFUSAL_CONFLICTING_VALUES = 5,
    /** More steps than `limit`. */
    NSRM_REFUSAL_TOO_MANY_STEPS = 6,
    /** A step describes more objects than its two: `step`, `span`, `limit`. */
    NSRM_REFUSAL_TOO_MANY_REFERENCES = 7,
    /** A step does not describe both of its objects: `step`, `span`, `references`. */
    NSRM_REFUSAL_INCOMPLETE_STEP = 8,
    /** The same words were taken for both objects: `step`, `span`. */
    NSRM_REFUSAL_SAME_REFERENCE = 9,
    /** The parser is not sure enough: `step`, `probability`, `threshold`; `detail` is the decision. */
    NSRM_REFUSAL_UNSURE = 10,
    /**
     * No object fits: `step`, `argument`, `description`, `threshold`; the best one is the only
     * candidate.
     */
    NSRM_REFUSAL_NO_SUCH_OBJECT = 11,
    /** Several objects fit: `step`, `argument`, `description`, `candidates`. */
    NSRM_REFUSAL_AMBIGUOUS = 12,
    /** Both descriptions fit the same object, and no other: `step`, `object`. */
    NSRM_REFUSAL_SAME_OBJECT = 13,
    /** A network's result is not finite: `step`; `detail` is the result. */
    NSRM_REFUSAL_NOT_FINITE = 14,
    /** A sub-goal is outside the work space: `step`, `object`, `position`. */
    NSRM_REFUSAL_OUTSIDE_WORK_SPACE = 15,
    /** The scene's embeddings were computed by another model. */
    NSRM_REFUSAL_OTHER_MODEL = 16,
    /**
     * The scene disagrees with the camera's calibration: `object`, `measured_m`, `expected_m`;
     * `detail` is what was measured.
     */
    NSRM_REFUSAL_CALIBRATION = 17,
    /** The sentence was parsed by another model. */
    NSRM_REFUSAL_PARSED_BY_OTHER_MODEL = 18,
    /** The model has an invalid index; impossible if `nsrm_model_check` has passed. */
    NSRM_REFUSAL_INVALID_MODEL = 19,
    /** The plan as a whole is not confident enough: `probability`, `threshold`. */
    NSRM_REFUSAL_LOW_CONFIDENCE = 20,
    /**
     * The words of a step are known, but not in this order: `step`, `span`, `probability`,
     * `threshold`.
     */
    NSRM_REFUSAL_UNCLEAR_WORDS = 21,
    /** A description has more relations than `limit`: `step`, `span`. */
    NSRM_REFUSAL_TOO_MANY_RELATIONS = 22,
    /**
     * An object is outside what the training's camera would see, or is seen from lower: `step`,
     * `argument`, `object`.
     */
    NSRM_REFUSAL_OUTSIDE_TRAINING_VIEW = 23,
    /** A pronoun may mean one or another object: `step`, `span`. */
    NSRM_REFUSAL_UNCLEAR_PRONOUN = 24,
    /** Several objects are described where a single one is needed: `step`, `span`. */
    NSRM_REFUSAL_SEVERAL_REFERENCES = 25,
    /**
     * Another number of objects fits a description than it says: `step`, `argument`, `description`,
     * `limit` objects expected, `fitting`.
     */
    NSRM_REFUSAL_OTHER_NUMBER = 26,
    /** The table is moved, described, or something is put beside it: `step`, `span`. */
    NSRM_REFUSAL_ONLY_ON_TABLE = 27,
    /** What is to be put on the table stands there already: `step`, `object`. */
    NSRM_REFUSAL_ALREADY_ON_TABLE = 28,
    /** No place on the table is free, in sight and inside the work space: `step`, `object`. */
    NSRM_REFUSAL_NO_ROOM_ON_TABLE = 29,
    /** A distance is named from an object of which too little is seen: `step`, `object`. */
    NSRM_REFUSAL_HIDDEN_REFERENCE = 30,
    /** What is to be moved by a distance from where it is does not stand on the table: `step`, `object`. */
    NSRM_REFUSAL_NOT_ON_TABLE = 31,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum nsrm_refusal_kind_t nsrm_refusal_kind_t;
#else
typedef uint32_t nsrm_refusal_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/** How an object is related to another one. */
enum nsrm_relation_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /** It is where an action puts things: "left of" is where `MoveLeft` does. */
    NSRM_RELATION_ACTION = 0,
    /** It is the nearest to the other object, of all that fit. */
    NSRM_RELATION_NEAREST = 1,
    /** It is the farthest from the other object, of all that fit. */
    NSRM_RELATION_FARTHEST = 2,
    /** None: the other object is a further reference, of what is put or lies between two. */
    NSRM_RELATION_AND = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum nsrm_relation_kind_t nsrm_relation_kind_t;
#else
typedef uint32_t nsrm_relation_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A model: the trained parameters, by reference. Read only; any number of tasks and threads may use
 * it at once.
 */
typedef struct nsrm_model_t nsrm_model_t;

/**
 * A camera: pinhole without distortion. Its optical frame: x right, y down, z forward. The world's
 * frame: the robot's base at the origin, x forward, y left, z up.
 */
typedef struct nsrm_camera_t {
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
    /** Orientation of the optical frame in the world's frame: a unit quaternion x, y, z, w. */
    float orientation[4];
} nsrm_camera_t;

/** Numbers of a model. */
typedef struct nsrm_model_info_t {
    /** `sizeof(nsrm_model_info_t)`; set it before the call. */
    uint32_t size;
    /** How many actions it knows: indices of `nsrm_action_name`. */
    uint32_t actions;
    /** How many attribute values it knows: indices of `nsrm_concept_name`. */
    uint32_t concepts;
    /** How many words it knows, besides those that name attribute values. */
    uint32_t words;
    /** Ties a scene's embeddings to the model that computed them. */
    uint64_t tag;
    /** The least score, a cosine, with which an object fits a description. */
    float match_score;
    /** The least accepted probability of one of the parser's decisions. */
    float decision;
    /** The least accepted confidence of a plan. */
    float confidence;
    /** Least x, y, z of a sub-goal: world frame, metres. */
    float work_space_min[3];
    /** Greatest x, y, z of a sub-goal: world frame, metres. */
    float work_space_max[3];
    /** The camera that saw the demonstrations. */
    struct nsrm_camera_t training_camera;
    /** Bits of a weight of its large layers: 32, as trained, or 8. */
    uint32_t weight_bits;
    /**
     * How many further actions it knows that are made of others, "next to": indices of `nsrm_action_name`
     * behind `actions`.
     */
    uint32_t compounds;
    /** What it can count, "the second from the left": indices of `nsrm_ranked_name`. */
    uint32_t ranked;
} nsrm_model_info_t;

/** UTF-8 text without a zero behind it. */
typedef struct nsrm_text_t {
    /** Its bytes; null if there is no text. */
    const char *data;
    /** How many. */
    size_t length;
} nsrm_text_t;

/** Memory of an observer, which the caller owns; as a task's. */
typedef union nsrm_observer_t {
    /** Aligns it. */
    uint64_t alignment;
    /** Its bytes. */
    uint8_t bytes[NSRM_OBSERVER_BYTES];
} nsrm_observer_t;

/** An image: red, green and blue, a byte each, row by row from the top. */
typedef struct nsrm_image_t {
    /** The pixels. */
    const uint8_t *pixels;
    /** Bytes that `pixels` points to. */
    size_t length;
    /** Pixels in a row. */
    uint32_t width;
    /** Rows. */
    uint32_t height;
    /** Bytes from the start of one row to that of the next; at least `3 * width`. */
    size_t stride;
} nsrm_image_t;

/** An object that a detector has found in an image. */
typedef struct nsrm_detection_t {
    /** Id of the object, the same in all scenes; not zero. */
    uint32_t id;
    /** Corners x1, y1, x2, y2 of the box around its visible part, as fractions of the image. */
    float visible[4];
    /**
     * Corners of the box around the whole object, including hidden parts as far as they are known,
     * then the mean depth of its pixels in metres.
     */
    float location[5];
} nsrm_detection_t;

/** An object in the camera's view. */
typedef struct nsrm_object_t {
    /** Id of the object, the same in all scenes; not zero. */
    uint32_t id;
    /**
     * Box corners x1, y1, x2, y2 as fractions of the image's width and height, then the mean depth of
     * its visible pixels in metres.
     */
    float location[5];
    /** What `nsrm_observe` computed from its crop. */
    float embedding[NSRM_EMBEDDING];
} nsrm_object_t;

/**
 * An observed scene. `nsrm_observe` makes one, and so does a perception process: it has the same bytes
 * as `nsrm_scene_message` of nsrm_messages.h.
 */
typedef struct nsrm_scene_t {
    /** Version of this layout: 1. */
    uint32_t schema;
    /** Frame of reference of the camera's pose: 0, the world's. */
    uint32_t frame;
    /** Tag of the model that computed the embeddings. */
    uint64_t model_tag;
    /** Sequence number: increases with each scene of one publisher. */
    uint64_t sequence;
    /** When the image was taken, nanoseconds on the publisher's clock. */
    uint64_t timestamp_ns;
    /** The camera. */
    struct nsrm_camera_t camera;
    /** How many objects there are. */
    uint32_t count;
    /** The objects; those behind the first `count` are ignored. */
    struct nsrm_object_t objects[NSRM_MAX_OBJECTS];
} nsrm_scene_t;

/**
 * Memory of a task, which the caller owns: static, on the stack or anywhere else. Initialise it with
 * `nsrm_begin` or another function that begins; it needs no cleaning up. Do not copy it while something
 * is begun in it.
 */
typedef union nsrm_task_t {
    /** Aligns it. */
    uint64_t alignment;
    /** Its bytes. */
    uint8_t bytes[NSRM_TASK_BYTES];
} nsrm_task_t;

/** The object that a description refers to. */
typedef struct nsrm_grounding_t {
    /** Id of the object. */
    uint32_t object;
    /** How well it fits: the least cosine of the description's values and of its relation. */
    float score;
    /** The probability that this object is meant, with all that the description relates it to. */
    float probability;
    /** How many objects the description relates it to. */
    uint32_t anchor_count;
    /** Their ids; 0 behind the last. */
    uint32_t anchors[NSRM_MAX_RELATIONS];
} nsrm_grounding_t;

/** The probabilities of a step's choices. */
typedef struct nsrm_confidence_t {
    /** That the step ends where the sentence was split. */
    float split;
    /** That all words stand where commands have them. */
    float words;
    /** That the action is right. */
    float action;
    /** That the words' relations to each other are right. */
    float relations;
    /** That these words describe the object to move. */
    float object;
    /** That these words describe the reference. */
    float reference;
    /** That the description refers to this object. */
    float object_unique;
    /** That the description refers to this reference. */
    float reference_unique;
} nsrm_confidence_t;

/** One step of a plan: which object to move, and where. */
typedef struct nsrm_sub_goal_t {
    /** Number of the step in the program, from 0. */
    uint32_t step;
    /** Index of the action. */
    uint32_t action;
    /** The object to move. */
    struct nsrm_grounding_t object;
    /** The reference; of the table, the object beside which there is room. */
    struct nsrm_grounding_t reference;
    /** Where the object's centre is to be: world frame, metres. */
    float position[3];
    /** How it is to be turned: a unit quaternion x, y, z, w. */
    float orientation[4];
    /**
     * Where it will be observed: box corners x1, y1, x2, y2 as fractions of the image, mean depth in
     * metres; may lie outside the image.
     */
    float location[5];
    /** The probabilities of the step's choices. */
    struct nsrm_confidence_t confidence;
} nsrm_sub_goal_t;

/** A plan in a scene. */
typedef struct nsrm_plan_t {
    /** `sizeof(nsrm_plan_t)`; set it before the call. */
    uint32_t size;
    /** How many sub-goals there are. */
    uint32_t count;
    /** The probability that every choice of the plan is right. */
    float confidence;
    /** The sub-goals in the order of execution; 0 behind the last. */
    struct nsrm_sub_goal_t sub_goals[NSRM_MAX_STEPS];
} nsrm_plan_t;

/** Attribute values that an object must have, and which of several it is: "leftmost small red". */
typedef struct nsrm_filters_t {
    /** How many; 0 for a noun without values. */
    uint32_t count;
    /** Their indices, in the order of the sentence; 0 behind the last. */
    uint8_t concepts[NSRM_MAX_FILTERS];
    /**
     * Which of the objects that have them: 0 if that is left open, `NSRM_LARGEST`, `NSRM_SMALLEST`, or
     * `NSRM_FARTHEST_BY` plus the index of the action in whose direction it lies farthest; "leftmost" is
     * that of `MoveLeft`. `NSRM_RANKED` plus an index is what is counted from there. Several that are moved
     * are `NSRM_ALL`, `NSRM_BOTH` or `NSRM_EACH`. The table, `NSRM_TABLE`, has no values: it is only a
     * reference, or what an object stands on.
     */
    uint32_t which;
} nsrm_filters_t;

/** A relation to another object: "left of the yellow one". */
typedef struct nsrm_relation_t {
    /** Its kind, of `nsrm_relation_kind_t`. */
    uint32_t kind;
    /** Index of the action that brings the relation about; 0 for other kinds. */
    uint32_t action;
    /** What the other object looks like. */
    struct nsrm_filters_t to;
} nsrm_relation_t;

/** What describes one object. */
typedef struct nsrm_description_t {
    /** What the object itself looks like. */
    struct nsrm_filters_t filters;
    /**
     * What objects look like that are not meant though all else fits, "except the red one"; without concepts if
     * none is left out. `which` is 0 for a single one, or `NSRM_ALL` for any number.
     */
    struct nsrm_filters_t except;
    /** How many relations there are. */
    uint32_t relation_count;
    /** The object's own relation to another one, then that one's to a third; 0 behind the last. */
    struct nsrm_relation_t relations[NSRM_MAX_RELATIONS];
} nsrm_description_t;

/** A part of the sentence, in bytes. */
typedef struct nsrm_span_t {
    /** First byte. */
    uint16_t start;
    /** One behind the last byte. */
    uint16_t end;
} nsrm_span_t;

/** One step of a program. */
typedef struct nsrm_program_step_t {
    /** Index of the action. */
    uint32_t action;
    /** The object to move. */
    struct nsrm_description_t object;
    /** The reference. */
    struct nsrm_description_t reference;
    /**
     * The distance between the faces of the two, millimetres; 0 where the sentence names none. With
     * `NSRM_ITSELF` as the reference, that by which the object is moved.
     */
    uint32_t distance_mm;
    /** The step's place in the sentence. */
    struct nsrm_span_t span;
    /** The place of the words that describe the object to move. */
    struct nsrm_span_t object_span;
    /** The place of the words that describe the reference. */
    struct nsrm_span_t reference_span;
    /** The probability that the parser's choices are right. */
    float probability;
} nsrm_program_step_t;

/** A misspelt word of the sentence, and what it was read as: tell the person. */
typedef struct nsrm_correction_t {
    /** The word's place in the sentence. */
    struct nsrm_span_t span;
    /** The known word; the text lives as long as the model. */
    struct nsrm_text_t read_as;
} nsrm_correction_t;

/** What a sentence says, independent of a scene. */
typedef struct nsrm_program_t {
    /** `sizeof(nsrm_program_t)`; set it before the call. */
    uint32_t size;
    /** How many steps it has. */
    uint32_t step_count;
    /** The steps in the order of execution; 0 behind the last. */
    struct nsrm_program_step_t steps[NSRM_MAX_STEPS];
    /** How many words were misspelt. */
    uint32_t correction_count;
    /** These words; 0 behind the last. */
    struct nsrm_correction_t corrections[NSRM_MAX_CORRECTIONS];
} nsrm_program_t;

/** What a word says of an object. */
typedef struct nsrm_property_t {
    /** Its kind, of `nsrm_property_kind_t`. */
    uint32_t kind;
    /** Index of the concept, or else `which` as in `nsrm_filters_t`. */
    uint32_t value;
} nsrm_property_t;

/** An object that fits a description. */
typedef struct nsrm_candidate_t {
    /** Its id. */
    uint32_t object;
    /** Its score, a cosine. */
    float score;
} nsrm_candidate_t;

/**
 * Why a sentence is refused, for programs; `nsrm_refusal_message` says it to people. What a kind does
 * not name is 0.
 */
typedef struct nsrm_refusal_t {
    /** `sizeof(nsrm_refusal_t)`; set it before the call. */
    uint32_t size;
    /** The number of an `nsrm_refusal_kind_t`. */
    uint32_t kind;
    /** Which step, from 0. */
    uint32_t step;
    /** Which argument: 1 for the object to move, 2 for the reference, 0 for none. */
    uint32_t argument;
    /** The place in the sentence. */
    struct nsrm_span_t span;
    /** The greatest number or length. */
    uint32_t limit;
    /** How many objects the step describes. */
    uint32_t references;
    /** The two values. */
    struct nsrm_property_t values[2];
    /** The description that does not fit, or fits several. */
    struct nsrm_description_t description;
    /** Id of the object. */
    uint32_t object;
    /** How many objects fit. */
    uint32_t fitting;
    /** How many of them are listed. */
    uint32_t candidate_count;
    /** These objects, the best first; 0 behind the last. */
    struct nsrm_candidate_t candidates[NSRM_MAX_CANDIDATES];
    /** The probability. */
    float probability;
    /** The least one, or the least score, with which it would have been accepted. */
    float threshold;
    /** Where the object's centre would be: world frame, metres. */
    float position[3];
    /** What was measured, metres. */
    float measured_m;
    /** What would agree with the calibration, metres. */
    float expected_m;
    /** Which unit, decision, result or quantity: a name in snake case that lives for ever. */
    struct nsrm_text_t detail;
} nsrm_refusal_t;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/** The built-in model: toy blocks on a table. Never null. */
const struct nsrm_model_t *nsrm_tabletop(void);

/**
 * The built-in model with weights of eight bits. Never null. Not in every library: see
 * `NSRM_PRECISIONS` of CMake.
 */
const struct nsrm_model_t *nsrm_tabletop_int8(void);

/**
 * Checks a model as a loader does: every index is valid, every list is sorted, the header is valid.
 * `NSRM_ERROR_NOT_A_MODEL` if it must not be used.
 *
 * Safety:
 * The pointer is valid or null.
 */
nsrm_status_t nsrm_model_check(const struct nsrm_model_t *model);

/**
 * Numbers of a model.
 *
 * Safety:
 * The pointers are valid or null.
 */
nsrm_status_t nsrm_model_info(const struct nsrm_model_t *model, struct nsrm_model_info_t *info);

/**
 * The name of an action: `MoveOn`; behind `actions`, of one that is made of others: `MoveNextTo`. The text
 * lives as long as the model.
 *
 * Safety:
 * The pointers are valid or null.
 */
nsrm_status_t nsrm_action_name(const struct nsrm_model_t *model,
                               uint32_t index,
                               struct nsrm_text_t *name);

/**
 * The name of an attribute value: `red`. The text lives as long as the model.
 *
 * Safety:
 * The pointers are valid or null.
 */
nsrm_status_t nsrm_concept_name(const struct nsrm_model_t *model,
                                uint32_t index,
                                struct nsrm_text_t *name);

/**
 * The name of what is counted: `second leftmost`. The text lives as long as the model.
 *
 * Safety:
 * The pointers are valid or null.
 */
nsrm_status_t nsrm_ranked_name(const struct nsrm_model_t *model,
                               uint32_t index,
                               struct nsrm_text_t *name);

/**
 * Begins to make a scene from an image and what a detector has found in it; `nsrm_observe_poll` does
 * the work.
 *
 * Returns `NSRM_PENDING`, `NSRM_INVALID_INPUT` if the image or the number of detections is invalid, or
 * an error.
 *
 * * `camera`: whose image it is, calibrated
 * * `detections`, `count`: at most `NSRM_MAX_OBJECTS`
 * * `sequence`: increases with each scene
 * * `timestamp_ns`: when the image was taken, nanoseconds
 *
 * The model, the pixels and the detections must stay where they are, unchanged, until it is done.
 *
 * Safety:
 * Each pointer is null or valid, and points to as much as it says.
 */
nsrm_status_t nsrm_observe_begin(union nsrm_observer_t *observer,
                                 const struct nsrm_model_t *model,
                                 const struct nsrm_image_t *image,
                                 const struct nsrm_camera_t *camera,
                                 const struct nsrm_detection_t *detections,
                                 size_t count,
                                 uint64_t sequence,
                                 uint64_t timestamp_ns);

/**
 * Encodes one object. Returns `NSRM_PENDING` until it is done, then `NSRM_OK`, or `NSRM_INVALID_INPUT`;
 * the scene is written only with `NSRM_OK`.
 *
 * Safety:
 * `observer` is null, or memory in which something was begun, or that is all zero; `scene` is null or
 * valid.
 */
nsrm_status_t nsrm_observe_poll(union nsrm_observer_t *observer,
                                struct nsrm_scene_t *scene);

/**
 * Makes a scene at once: `nsrm_observe_begin`, then `nsrm_observe_poll` to the end. Unless it returns
 * `NSRM_OK`, the scene is one that no planner accepts.
 *
 * Safety:
 * As theirs.
 */
nsrm_status_t nsrm_observe(union nsrm_observer_t *observer,
                           const struct nsrm_model_t *model,
                           const struct nsrm_image_t *image,
                           const struct nsrm_camera_t *camera,
                           const struct nsrm_detection_t *detections,
                           size_t count,
                           uint64_t sequence,
                           uint64_t timestamp_ns,
                           struct nsrm_scene_t *scene);

/**
 * Why an observer has no scene, for a person; see `nsrm_refusal_message`.
 *
 * Safety:
 * As `nsrm_observe_poll`'s; `buffer` points to `size` bytes, `needed` is null or valid.
 */
nsrm_status_t nsrm_observer_message(union nsrm_observer_t *observer,
                                    char *buffer,
                                    size_t size,
                                    size_t *needed);

/** `NSRM_OBSERVER_BYTES` of the library: compare it with the header's. */
size_t nsrm_observer_bytes(void);

/**
 * A scene without objects, as the model's planner expects it.
 *
 * Safety:
 * The pointers are null or valid.
 */
nsrm_status_t nsrm_scene_init(struct nsrm_scene_t *scene,
                              const struct nsrm_model_t *model,
                              const struct nsrm_camera_t *camera);

/** The meaning of a status, for a person; "unknown status" for any other number. Never null. */
const char *nsrm_status_text(int32_t status);

/**
 * Begins to plan a sentence in a scene; `nsrm_poll` does the work.
 *
 * Returns `NSRM_PENDING`, `NSRM_INVALID_INPUT` if the scene is invalid, or an error.
 *
 * * `sentence`: UTF-8, `length` bytes; it needs no zero behind it
 *
 * The model, the scene and the sentence must stay where they are, unchanged, as long as the task is
 * used. The scene is checked once, here.
 *
 * Safety:
 * Each pointer is null or valid; `sentence` points to `length` bytes.
 */
nsrm_status_t nsrm_begin(union nsrm_task_t *task,
                         const struct nsrm_model_t *model,
                         const struct nsrm_scene_t *scene,
                         const char *sentence,
                         size_t length);

/**
 * Begins to parse a sentence without a scene, as `nsrm_begin` begins to plan one.
 *
 * Safety:
 * As `nsrm_begin`'s.
 */
nsrm_status_t nsrm_begin_parsing(union nsrm_task_t *task,
                                 const struct nsrm_model_t *model,
                                 const char *sentence,
                                 size_t length);

/**
 * Begins to ground the program that a task has parsed in a scene as it is now, from step `first` on
 * (from 0): a plan for the rest of the sentence. Refusals count steps as in the whole sentence.
 *
 * The task is one whose program `nsrm_get_program` gives: parsed, planned or grounded before. Returns
 * what `nsrm_begin` does; the task then has this result.
 *
 * Safety:
 * As `nsrm_begin`'s.
 */
nsrm_status_t nsrm_begin_grounding(union nsrm_task_t *task,
                                   const struct nsrm_scene_t *scene,
                                   uint32_t first);

/**
 * Does one bounded unit of work. Returns `NSRM_PENDING` until it is done, then `NSRM_OK` or
 * `NSRM_REFUSED`, also on every further call.
 *
 * Safety:
 * `task` is null, or memory in which something was begun, or that is all zero.
 */
nsrm_status_t nsrm_poll(union nsrm_task_t *task);

/**
 * Plans a sentence in a scene at once: `nsrm_begin`, `nsrm_poll` to the end and `nsrm_get_plan`.
 *
 * Returns `NSRM_OK`, `NSRM_REFUSED`, `NSRM_INVALID_INPUT` or an error. Unless it is `NSRM_OK`, the plan
 * has no sub-goals.
 *
 * Safety:
 * As `nsrm_begin`'s.
 */
nsrm_status_t nsrm_plan(union nsrm_task_t *task,
                        const struct nsrm_model_t *model,
                        const struct nsrm_scene_t *scene,
                        const char *sentence,
                        size_t length,
                        struct nsrm_plan_t *plan);

/**
 * Parses a sentence at once: `nsrm_begin_parsing`, `nsrm_poll` to the end and `nsrm_get_program`. Unless
 * it returns `NSRM_OK`, the program has no steps.
 *
 * Safety:
 * As `nsrm_begin`'s.
 */
nsrm_status_t nsrm_parse(union nsrm_task_t *task,
                         const struct nsrm_model_t *model,
                         const char *sentence,
                         size_t length,
                         struct nsrm_program_t *program);

/**
 * Checks that a scene agrees with the camera's calibration, as planning does first; use it when a
 * camera is set up. Returns `NSRM_OK`, `NSRM_REFUSED`, `NSRM_INVALID_INPUT` or an error.
 *
 * Safety:
 * As `nsrm_begin`'s.
 */
nsrm_status_t nsrm_check(union nsrm_task_t *task,
                         const struct nsrm_model_t *model,
                         const struct nsrm_scene_t *scene);

/**
 * The plan of a task that is done. Unless it returns `NSRM_OK`, the plan has no sub-goals.
 *
 * Safety:
 * As `nsrm_poll`'s; `plan` is null or valid, its size set.
 */
nsrm_status_t nsrm_get_plan(union nsrm_task_t *task, struct nsrm_plan_t *plan);

/**
 * The program of a task that has parsed its sentence, also if there is no plan in the scene. Unless it
 * returns `NSRM_OK`, the program has no steps.
 *
 * Safety:
 * As `nsrm_poll`'s; `program` is null or valid, its size set.
 */
nsrm_status_t nsrm_get_program(union nsrm_task_t *task,
                               struct nsrm_program_t *program);

/**
 * Why a task has no result.
 *
 * Safety:
 * As `nsrm_poll`'s; `refusal` is null or valid, its size set.
 */
nsrm_status_t nsrm_get_refusal(union nsrm_task_t *task, struct nsrm_refusal_t *refusal);

/**
 * Why a task has no result, in full sentences for a person: of a refusal, or of an invalid scene.
 *
 * * `buffer`, `size`: where the text goes, UTF-8 with a zero behind it; cut if it does not fit
 *   (`NSRM_TRUNCATED`)
 * * `needed`: how many bytes it takes, the zero included; may be null
 *
 * Safety:
 * As `nsrm_poll`'s; `buffer` points to `size` bytes, `needed` is null or valid.
 */
nsrm_status_t nsrm_refusal_message(union nsrm_task_t *task,
                                   char *buffer,
                                   size_t size,
                                   size_t *needed);

/**
 * The program in the paper's notation, a line for each step; see `nsrm_refusal_message`.
 *
 * Safety:
 * As `nsrm_refusal_message`'s.
 */
nsrm_status_t nsrm_program_notation(union nsrm_task_t *task,
                                    char *buffer,
                                    size_t size,
                                    size_t *needed);

/**
 * What the plan does and why, a sentence for each step; see `nsrm_refusal_message`.
 *
 * Safety:
 * As `nsrm_refusal_message`'s.
 */
nsrm_status_t nsrm_plan_explanation(union nsrm_task_t *task,
                                    char *buffer,
                                    size_t size,
                                    size_t *needed);

/** `NSRM_TASK_BYTES` of the library: compare it with the header's. */
size_t nsrm_task_bytes(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* NSRM_H */
