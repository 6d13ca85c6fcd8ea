/* Does what standard input says, and prints everything that comes of it; numbers as the bits of their
 * floats. The same from Rust: tests/tests/c_interface/.
 *
 * Input, all numbers little-endian, one request behind the other:
 *
 *     'P' scene, uint32_t length, sentence      plan: at once, and polled
 *     'S' uint32_t length, sentence             parse: at once, and polled
 *     'G' scene, uint32_t first                 ground the sentence parsed last
 *     'O' camera, uint32_t width, height, count, detections, pixels    observe
 */

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nsrm.h"

/* The model that Rust has computed with. */
#ifndef MODEL
#define MODEL nsrm_tabletop
#endif

static nsrm_task_t task;
static nsrm_observer_t observer;
static nsrm_scene_t scene;
static char sentence[2 * NSRM_MAX_SENTENCE_BYTES];

static void fail(const char *what) {
    fprintf(stderr, "conformance: %s\n", what);
    exit(1);
}

static void get(void *to, size_t size) {
    if (fread(to, 1, size, stdin) != size) {
        fail("the input ends early");
    }
}

static uint32_t get_number(void) {
    uint32_t number;
    get(&number, sizeof number);
    return number;
}

static size_t get_sentence(void) {
    const uint32_t length = get_number();
    if (length > sizeof sentence) {
        fail("the sentence is too long");
    }
    get(sentence, length);
    return length;
}

static void put_floats(const float *values, size_t count) {
    for (size_t index = 0; index < count; ++index) {
        uint32_t bits;
        memcpy(&bits, &values[index], sizeof bits);
        printf(" %08" PRIx32, bits);
    }
}

/* Through a buffer of exactly the size that it takes. */
static void put_text(const char *what,
                     nsrm_status_t (*write)(nsrm_task_t *, char *, size_t, size_t *)) {
    size_t needed = 0;
    if (write(&task, NULL, 0, &needed) != NSRM_TRUNCATED) {
        fail("no text");
    }
    char *text = malloc(needed);
    if (text == NULL || write(&task, text, needed, NULL) != NSRM_OK ||
        strlen(text) + 1 != needed) {
        fail("another text");
    }
    printf("%s: %s\n", what, text);
    free(text);
}

static void put_refusal(void) {
    nsrm_refusal_t refusal;
    memset(&refusal, 0, sizeof refusal);
    refusal.size = sizeof refusal;
    if (nsrm_get_refusal(&task, &refusal) != NSRM_OK) {
        fail("no refusal");
    }
    printf("refused: kind %" PRIu32 " step %" PRIu32 " argument %" PRIu32 " span %u %u object %" PRIu32
           " fitting %" PRIu32 " candidates",
           refusal.kind, refusal.step, refusal.argument, (unsigned)refusal.span.start,
           (unsigned)refusal.span.end, refusal.object, refusal.fitting);
    for (uint32_t index = 0; index < refusal.candidate_count; ++index) {
        printf(" %" PRIu32, refusal.candidates[index].object);
        put_floats(&refusal.candidates[index].score, 1);
    }
    printf(" detail %.*s\n", (int)refusal.detail.length,
           refusal.detail.data == NULL ? "" : refusal.detail.data);
    put_text("message", nsrm_refusal_message);
}

static void put_grounding(const nsrm_grounding_t *grounding) {
    printf(" object %" PRIu32, grounding->object);
    put_floats(&grounding->score, 1);
    put_floats(&grounding->probability, 1);
    for (uint32_t index = 0; index < grounding->anchor_count; ++index) {
        printf(" anchor %" PRIu32, grounding->anchors[index]);
    }
}

static void put_plan(const nsrm_plan_t *plan) {
    printf("confidence");
    put_floats(&plan->confidence, 1);
    printf("\n");
    for (uint32_t index = 0; index < plan->count; ++index) {
        const nsrm_sub_goal_t *goal = &plan->sub_goals[index];
        printf("step %" PRIu32 " action %" PRIu32, goal->step, goal->action);
        put_grounding(&goal->object);
        put_grounding(&goal->reference);
        printf(" goal");
        put_floats(goal->position, 3);
        put_floats(goal->orientation, 4);
        put_floats(goal->location, 5);
        put_floats(&goal->confidence.split, 1);
        put_floats(&goal->confidence.reference_unique, 1);
        printf("\n");
    }
    put_text("explanation", nsrm_plan_explanation);
}

static void put_program(void) {
    nsrm_program_t program;
    memset(&program, 0, sizeof program);
    program.size = sizeof program;
    if (nsrm_get_program(&task, &program) != NSRM_OK) {
        fail("no program");
    }
    for (uint32_t index = 0; index < program.step_count; ++index) {
        const nsrm_program_step_t *step = &program.steps[index];
        printf("parsed: action %" PRIu32 " concepts %" PRIu32 " %" PRIu32 " relations %" PRIu32
               " %" PRIu32 " kinds %" PRIu32 " %" PRIu32 " which %" PRIu32 " %" PRIu32
               " mm %" PRIu32 " span %u %u\n",
               step->action, step->object.filters.count, step->reference.filters.count,
               step->object.relation_count, step->reference.relation_count,
               step->object.relations[0].kind, step->reference.relations[0].kind,
               step->object.filters.which, step->reference.filters.which, step->distance_mm,
               (unsigned)step->span.start, (unsigned)step->span.end);
    }
    for (uint32_t index = 0; index < program.correction_count; ++index) {
        const nsrm_correction_t *correction = &program.corrections[index];
        printf("corrected: %u %u %.*s\n", (unsigned)correction->span.start,
               (unsigned)correction->span.end, (int)correction->read_as.length,
               correction->read_as.data);
    }
    put_text("notation", nsrm_program_notation);
}

static nsrm_status_t polled(nsrm_status_t status) {
    for (unsigned long polls = 0; status == NSRM_PENDING; ++polls) {
        if (polls > NSRM_MAX_POLLS) {
            fail("it is never done");
        }
        status = nsrm_poll(&task);
    }
    return status;
}

static void put_result(nsrm_status_t status, const nsrm_plan_t *plan) {
    if (status == NSRM_OK) {
        put_program();
        put_plan(plan);
    } else if (status == NSRM_REFUSED) {
        put_refusal();
    } else if (status == NSRM_INVALID_INPUT) {
        put_text("invalid", nsrm_refusal_message);
    } else {
        printf("status %d: %s\n", (int)status, nsrm_status_text(status));
    }
}

static void plan(void) {
    get(&scene, sizeof scene);
    const size_t length = get_sentence();
    static nsrm_plan_t whole, in_parts;
    memset(&whole, 0, sizeof whole);
    memset(&in_parts, 0, sizeof in_parts);
    whole.size = in_parts.size = sizeof whole;
    const nsrm_model_t *model = MODEL();
    const nsrm_status_t status = nsrm_plan(&task, model, &scene, sentence, length, &whole);
    if (polled(nsrm_begin(&task, model, &scene, sentence, length)) != status) {
        fail("nsrm_plan and nsrm_poll disagree");
    }
    if (status == NSRM_OK && (nsrm_get_plan(&task, &in_parts) != NSRM_OK ||
                              memcmp(&whole, &in_parts, sizeof whole) != 0)) {
        fail("nsrm_plan and nsrm_get_plan disagree");
    }
    put_result(status, &whole);
}

static void parse(void) {
    const size_t length = get_sentence();
    nsrm_program_t program;
    memset(&program, 0, sizeof program);
    program.size = sizeof program;
    const nsrm_model_t *model = MODEL();
    const nsrm_status_t status = nsrm_parse(&task, model, sentence, length, &program);
    if (polled(nsrm_begin_parsing(&task, model, sentence, length)) != status) {
        fail("nsrm_parse and nsrm_poll disagree");
    }
    if (status == NSRM_OK) {
        put_program();
    } else {
        put_result(status, NULL);
    }
}

static void ground(void) {
    get(&scene, sizeof scene);
    const uint32_t first = get_number();
    static nsrm_plan_t grounded;
    memset(&grounded, 0, sizeof grounded);
    grounded.size = sizeof grounded;
    const nsrm_status_t status = polled(nsrm_begin_grounding(&task, &scene, first));
    if (status == NSRM_OK && nsrm_get_plan(&task, &grounded) != NSRM_OK) {
        fail("no plan");
    }
    put_result(status, &grounded);
}

static void observe(void) {
    nsrm_camera_t camera;
    get(&camera, sizeof camera);
    const uint32_t width = get_number(), height = get_number(), count = get_number();
    nsrm_detection_t detections[NSRM_MAX_OBJECTS + 1];
    if (count > NSRM_MAX_OBJECTS + 1) {
        fail("too many detections");
    }
    get(detections, count * sizeof detections[0]);
    const size_t length = (size_t)3 * width * height;
    uint8_t *pixels = malloc(length);
    if (pixels == NULL) {
        fail("too large an image");
    }
    get(pixels, length);
    const nsrm_image_t image = {pixels, length, width, height, (size_t)3 * width};
    const nsrm_status_t status = nsrm_observe(&observer, MODEL(), &image, &camera,
                                              detections, count, 7, 9, &scene);
    free(pixels);
    if (status == NSRM_OK) {
        printf("scene %016" PRIx64 " %" PRIu64 " %" PRIu64 "\n", scene.model_tag, scene.sequence,
               scene.timestamp_ns);
        for (uint32_t index = 0; index < scene.count; ++index) {
            printf("object %" PRIu32, scene.objects[index].id);
            put_floats(scene.objects[index].location, 5);
            put_floats(scene.objects[index].embedding, NSRM_EMBEDDING);
            printf("\n");
        }
    } else if (status == NSRM_INVALID_INPUT) {
        char text[256];
        if (nsrm_observer_message(&observer, text, sizeof text, NULL) != NSRM_OK) {
            fail("no message");
        }
        printf("invalid: %s\n", text);
    } else {
        printf("status %d: %s\n", (int)status, nsrm_status_text(status));
    }
}

int main(void) {
    for (int request = getchar(); request != EOF; request = getchar()) {
        switch (request) {
        case 'P':
            plan();
            break;
        case 'S':
            parse();
            break;
        case 'G':
            ground();
            break;
        case 'O':
            observe();
            break;
        default:
            fail("an unknown request");
        }
        printf("\n");
    }
    return 0;
}
