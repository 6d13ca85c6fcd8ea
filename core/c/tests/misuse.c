/* Whatever a caller does wrong has an error code of its own, and no effect. Run with sanitizers and
 * under valgrind: all memory is exactly as large as the header says. */

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nsrm.h"

static int failures;

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);                        \
            ++failures;                                                                            \
        }                                                                                          \
    } while (0)

static const char GOOD[] = "put the red block on the blue block";
#define LENGTH (sizeof GOOD - 1)

static const nsrm_camera_t CAMERA = {
    640, 480, 600.0f, 600.0f, 320.0f, 240.0f, {0.5f, 0.0f, 1.0f}, {1.0f, 0.0f, 0.0f, 0.0f},
};

static void *zeros(size_t size) {
    void *memory = calloc(1, size);
    if (memory == NULL) {
        abort();
    }
    return memory;
}

/* One byte further: aligned for nothing. */
static void *odd(void *pointer) { return (char *)pointer + 1; }

static nsrm_scene_t *new_scene(void) {
    nsrm_scene_t *scene = zeros(sizeof *scene);
    CHECK(nsrm_scene_init(scene, nsrm_tabletop(), &CAMERA) == NSRM_OK);
    return scene;
}

static void pointers(void) {
    const nsrm_model_t *model = nsrm_tabletop();
    nsrm_task_t *task = zeros(2 * sizeof *task);
    nsrm_scene_t *scene = new_scene();
    nsrm_plan_t plan;
    memset(&plan, 0, sizeof plan);
    plan.size = sizeof plan;

    CHECK(nsrm_begin(NULL, model, scene, GOOD, LENGTH) == NSRM_ERROR_NULL);
    CHECK(nsrm_begin(task, NULL, scene, GOOD, LENGTH) == NSRM_ERROR_NULL);
    CHECK(nsrm_begin(task, model, NULL, GOOD, LENGTH) == NSRM_ERROR_NULL);
    CHECK(nsrm_begin(task, model, scene, NULL, LENGTH) == NSRM_ERROR_NULL);
    CHECK(nsrm_begin(odd(task), model, scene, GOOD, LENGTH) == NSRM_ERROR_MISALIGNED);
    CHECK(nsrm_begin(task, model, odd(scene), GOOD, LENGTH) == NSRM_ERROR_MISALIGNED);
    CHECK(nsrm_begin(task, (const nsrm_model_t *)(const void *)scene, scene, GOOD, LENGTH) ==
          NSRM_ERROR_NOT_A_MODEL);
    CHECK(nsrm_begin_parsing(task, model, NULL, 1) == NSRM_ERROR_NULL);
    CHECK(nsrm_plan(task, model, scene, GOOD, LENGTH, NULL) == NSRM_ERROR_NULL);
    CHECK(nsrm_plan(task, model, scene, GOOD, LENGTH, odd(&plan)) == NSRM_ERROR_MISALIGNED);
    CHECK(nsrm_parse(task, model, GOOD, LENGTH, NULL) == NSRM_ERROR_NULL);
    CHECK(nsrm_poll(NULL) == NSRM_ERROR_NULL);
    CHECK(nsrm_poll(odd(task)) == NSRM_ERROR_MISALIGNED);
    CHECK(nsrm_get_plan(NULL, &plan) == NSRM_ERROR_NULL);
    CHECK(nsrm_get_program(task, NULL) == NSRM_ERROR_NULL);
    CHECK(nsrm_get_refusal(task, NULL) != NSRM_OK);
    CHECK(nsrm_scene_init(NULL, model, &CAMERA) == NSRM_ERROR_NULL);
    CHECK(nsrm_scene_init(scene, model, NULL) == NSRM_ERROR_NULL);
    CHECK(nsrm_check(NULL, model, scene) == NSRM_ERROR_NULL);
    CHECK(nsrm_model_check(NULL) == NSRM_ERROR_NULL);
    CHECK(nsrm_model_check(model) == NSRM_OK);
    CHECK(nsrm_model_info(model, NULL) == NSRM_ERROR_NULL);
    /* No words at all need no pointer. */
    CHECK(nsrm_begin_parsing(task, model, NULL, 0) == NSRM_PENDING);
    CHECK(nsrm_poll(task) == NSRM_REFUSED);
    free(scene);
    free(task);
}

static void sizes(void) {
    nsrm_task_t *task = zeros(sizeof *task);
    nsrm_scene_t *scene = new_scene();
    nsrm_plan_t *plan = zeros(sizeof *plan);
    nsrm_program_t *program = zeros(sizeof *program);
    nsrm_refusal_t *refusal = zeros(sizeof *refusal);
    nsrm_model_info_t *info = zeros(sizeof *info);
    const nsrm_model_t *model = nsrm_tabletop();

    CHECK(nsrm_task_bytes() == NSRM_TASK_BYTES && sizeof *task == NSRM_TASK_BYTES);
    CHECK(nsrm_observer_bytes() == NSRM_OBSERVER_BYTES);
    CHECK(nsrm_plan(task, model, scene, GOOD, LENGTH, plan) == NSRM_ERROR_STRUCT_SIZE);
    CHECK(nsrm_parse(task, model, GOOD, LENGTH, program) == NSRM_ERROR_STRUCT_SIZE);
    CHECK(nsrm_model_info(model, info) == NSRM_ERROR_STRUCT_SIZE);
    plan->size = sizeof *plan;
    CHECK(nsrm_plan(task, model, scene, GOOD, LENGTH, plan) == NSRM_REFUSED);
    CHECK(plan->count == 0);
    CHECK(nsrm_get_refusal(task, refusal) == NSRM_ERROR_STRUCT_SIZE);
    refusal->size = sizeof *refusal;
    CHECK(nsrm_get_refusal(task, refusal) == NSRM_OK);
    CHECK(refusal->kind == NSRM_REFUSAL_NO_SUCH_OBJECT);
    program->size = sizeof *program;
    CHECK(nsrm_parse(task, model, GOOD, LENGTH, program) == NSRM_OK && program->step_count == 1);
    info->size = sizeof *info;
    CHECK(nsrm_model_info(model, info) == NSRM_OK);
    CHECK(info->tag == scene->model_tag && info->actions > 0 && info->concepts > 0);
    CHECK(info->weight_bits == 32);
    CHECK(nsrm_model_info(nsrm_tabletop_int8(), info) == NSRM_OK && info->weight_bits == 8);
    CHECK(nsrm_model_check(nsrm_tabletop_int8()) == NSRM_OK && info->tag == scene->model_tag);
    nsrm_text_t name;
    CHECK(nsrm_action_name(model, info->actions - 1, &name) == NSRM_OK && name.length > 0);
    const uint32_t known = info->actions + info->compounds;
    CHECK(info->compounds > 0);
    CHECK(nsrm_action_name(model, known - 1, &name) == NSRM_OK && name.length > 0);
    CHECK(nsrm_action_name(model, known, &name) == NSRM_ERROR_INDEX);
    CHECK(nsrm_action_name(model, UINT32_MAX, &name) == NSRM_ERROR_INDEX);
    CHECK(nsrm_ranked_name(model, info->ranked - 1, &name) == NSRM_OK && name.length > 0);
    CHECK(nsrm_ranked_name(model, info->ranked, &name) == NSRM_ERROR_INDEX);
    CHECK(nsrm_concept_name(model, UINT32_MAX, &name) == NSRM_ERROR_INDEX);
    CHECK(nsrm_concept_name(model, 0, NULL) == NSRM_ERROR_NULL);
    free(info);
    free(refusal);
    free(program);
    free(plan);
    free(scene);
    free(task);
}

/* A result before there is one, of another kind, or of nothing. */
static void order(void) {
    nsrm_task_t *task = zeros(sizeof *task);
    nsrm_scene_t *scene = new_scene();
    const nsrm_model_t *model = nsrm_tabletop();
    nsrm_plan_t plan;
    nsrm_program_t program;
    nsrm_refusal_t refusal;
    memset(&plan, 0, sizeof plan);
    memset(&program, 0, sizeof program);
    memset(&refusal, 0, sizeof refusal);
    plan.size = sizeof plan;
    program.size = sizeof program;
    refusal.size = sizeof refusal;

    for (int fill = 0; fill < 256; fill += 51) {
        memset(task, fill, sizeof *task);
        CHECK(nsrm_poll(task) == NSRM_ERROR_NOT_BEGUN);
        CHECK(nsrm_get_plan(task, &plan) == NSRM_ERROR_NOT_BEGUN);
        CHECK(nsrm_begin_grounding(task, scene, 0) == NSRM_ERROR_NOT_BEGUN);
    }
    CHECK(nsrm_begin_parsing(task, model, GOOD, LENGTH) == NSRM_PENDING);
    CHECK(nsrm_get_program(task, &program) == NSRM_ERROR_NOT_DONE && program.step_count == 0);
    CHECK(nsrm_get_refusal(task, &refusal) == NSRM_ERROR_NOT_DONE);
    CHECK(nsrm_get_plan(task, &plan) == NSRM_ERROR_NOT_BEGUN);
    CHECK(nsrm_begin_grounding(task, scene, 0) == NSRM_ERROR_NOT_DONE);
    nsrm_status_t status = NSRM_PENDING;
    while (status == NSRM_PENDING) {
        status = nsrm_poll(task);
    }
    CHECK(status == NSRM_OK && nsrm_poll(task) == NSRM_OK);
    CHECK(nsrm_get_refusal(task, &refusal) == NSRM_ERROR_NOT_BEGUN);
    CHECK(nsrm_begin_grounding(task, scene, 1) == NSRM_ERROR_INDEX);
    CHECK(nsrm_begin_grounding(task, scene, 0) == NSRM_PENDING);
    CHECK(nsrm_begin(task, model, scene, "\xff", 1) == NSRM_ERROR_NOT_UTF8);
    /* What could not begin leaves nothing behind. */
    CHECK(nsrm_poll(task) == NSRM_ERROR_NOT_BEGUN);
    free(scene);
    free(task);
}

static void scenes(void) {
    nsrm_task_t *task = zeros(sizeof *task);
    const nsrm_model_t *model = nsrm_tabletop();
    nsrm_plan_t plan;
    memset(&plan, 0, sizeof plan);
    plan.size = sizeof plan;
    char text[256];
    const char *expected[] = {"schema", "frame", "model", "fx", "orientation", "objects", "id", "id"};
    for (size_t fault = 0; fault < sizeof expected / sizeof expected[0]; ++fault) {
        nsrm_scene_t *scene = new_scene();
        switch (fault) {
        case 0:
            scene->schema = 9;
            break;
        case 1:
            scene->frame = 3;
            break;
        case 2:
            ++scene->model_tag;
            break;
        case 3:
            memset(&scene->camera.fx, 0xff, sizeof(float));
            break;
        case 4:
            scene->camera.orientation[0] = 2.0f;
            break;
        case 5:
            scene->count = NSRM_MAX_OBJECTS + 1;
            break;
        default:
            scene->count = 2;
            scene->objects[0].id = fault == 6 ? 0 : 4;
            scene->objects[1].id = 4;
            for (int index = 0; index < 2; ++index) {
                const float location[5] = {0.4f, 0.4f, 0.5f, 0.5f, 1.0f};
                memcpy(scene->objects[index].location, location, sizeof location);
            }
            break;
        }
        CHECK(nsrm_plan(task, model, scene, GOOD, LENGTH, &plan) == NSRM_INVALID_INPUT);
        CHECK(plan.count == 0);
        CHECK(nsrm_poll(task) == NSRM_INVALID_INPUT);
        CHECK(nsrm_refusal_message(task, text, sizeof text, NULL) == NSRM_OK);
        CHECK(strstr(text, expected[fault]) != NULL);
        CHECK(nsrm_check(task, model, scene) == NSRM_INVALID_INPUT);
        free(scene);
    }
    free(task);
}

static void sentences(void) {
    nsrm_task_t *task = zeros(sizeof *task);
    const nsrm_model_t *model = nsrm_tabletop();
    nsrm_program_t program;
    memset(&program, 0, sizeof program);
    program.size = sizeof program;
    const size_t lengths[] = {NSRM_MAX_SENTENCE_BYTES, NSRM_MAX_SENTENCE_BYTES + 1, 1000000};
    for (size_t index = 0; index < 3; ++index) {
        /* Without a zero behind it, in memory that ends with it. */
        char *sentence = malloc(lengths[index]);
        if (sentence == NULL) {
            abort();
        }
        memset(sentence, 'a', lengths[index]);
        CHECK(nsrm_parse(task, model, sentence, lengths[index], &program) == NSRM_REFUSED);
        nsrm_refusal_t refusal;
        refusal.size = sizeof refusal;
        CHECK(nsrm_get_refusal(task, &refusal) == NSRM_OK);
        CHECK(refusal.kind ==
              (index == 0 ? NSRM_REFUSAL_UNKNOWN_WORD : NSRM_REFUSAL_SENTENCE_TOO_LONG));
        free(sentence);
    }
    char cut[8];
    size_t needed = 0;
    CHECK(nsrm_parse(task, model, "fly", 3, &program) == NSRM_REFUSED);
    CHECK(nsrm_refusal_message(task, NULL, 8, &needed) == NSRM_ERROR_NULL);
    CHECK(nsrm_refusal_message(task, cut, sizeof cut, &needed) == NSRM_TRUNCATED);
    CHECK(needed > sizeof cut && strlen(cut) == sizeof cut - 1);
    CHECK(nsrm_program_notation(task, cut, sizeof cut, NULL) == NSRM_REFUSED);
    CHECK(nsrm_plan_explanation(task, cut, sizeof cut, NULL) == NSRM_ERROR_NOT_BEGUN);
    free(task);
}

static void images(void) {
    nsrm_observer_t *observer = zeros(sizeof *observer);
    nsrm_scene_t *scene = new_scene();
    const nsrm_model_t *model = nsrm_tabletop();
    const size_t length = (size_t)3 * 640 * 480;
    uint8_t *pixels = zeros(length);
    nsrm_image_t image = {pixels, length, 640, 480, 3 * 640};
    nsrm_detection_t detections[NSRM_MAX_OBJECTS + 1];
    memset(detections, 0, sizeof detections);
    char text[256];

    CHECK(nsrm_observe_poll(observer, scene) == NSRM_ERROR_NOT_BEGUN);
    CHECK(nsrm_observe(observer, model, &image, &CAMERA, detections, NSRM_MAX_OBJECTS + 1, 0, 0,
                       scene) == NSRM_ERROR_TOO_LARGE);
    CHECK(nsrm_observe(observer, model, &image, &CAMERA, NULL, 1, 0, 0, scene) == NSRM_ERROR_NULL);
    CHECK(nsrm_observe(observer, model, NULL, &CAMERA, detections, 1, 0, 0, scene) ==
          NSRM_ERROR_NULL);
    CHECK(nsrm_observe(observer, model, &image, &CAMERA, detections, 1, 0, 0, NULL) ==
          NSRM_ERROR_NULL);
    /* An id of zero. */
    CHECK(nsrm_observe(observer, model, &image, &CAMERA, detections, 1, 0, 0, scene) ==
          NSRM_INVALID_INPUT);
    CHECK(nsrm_observer_message(observer, text, sizeof text, NULL) == NSRM_OK);
    /* A scene that was not made is none, whatever it was before. */
    nsrm_task_t *task = zeros(sizeof *task);
    CHECK(nsrm_begin(task, model, scene, GOOD, LENGTH) == NSRM_INVALID_INPUT);
    --image.length;
    CHECK(nsrm_observe(observer, model, &image, &CAMERA, NULL, 0, 0, 0, scene) ==
          NSRM_INVALID_INPUT);
    CHECK(nsrm_observer_message(observer, text, sizeof text, NULL) == NSRM_OK);
    CHECK(strstr(text, "bytes") != NULL);
    ++image.length;
    CHECK(nsrm_observe(observer, model, &image, &CAMERA, NULL, 0, 3, 4, scene) == NSRM_OK);
    CHECK(scene->count == 0 && scene->sequence == 3 && scene->timestamp_ns == 4);
    CHECK(nsrm_observer_message(observer, text, sizeof text, NULL) == NSRM_ERROR_NOT_BEGUN);
    CHECK(nsrm_begin(task, model, scene, GOOD, LENGTH) == NSRM_PENDING);
    free(task);
    free(pixels);
    free(scene);
    free(observer);
}

/* Two threads at one task: each call either does its work or says that the task is busy. */
static void *poll_much(void *task) {
    unsigned long *busy = zeros(sizeof *busy);
    nsrm_status_t status = NSRM_PENDING;
    while (status == NSRM_PENDING || status == NSRM_ERROR_BUSY) {
        status = nsrm_poll(task);
        *busy += status == NSRM_ERROR_BUSY;
    }
    CHECK(status == NSRM_OK);
    return busy;
}

static void threads(void) {
    nsrm_task_t *task = zeros(sizeof *task);
    const nsrm_model_t *model = nsrm_tabletop();
    unsigned long met = 0;
    for (int round = 0; round < 10000 && met == 0; ++round) {
        CHECK(nsrm_begin_parsing(task, model, GOOD, LENGTH) == NSRM_PENDING);
        pthread_t others[2];
        for (int index = 0; index < 2; ++index) {
            CHECK(pthread_create(&others[index], NULL, poll_much, task) == 0);
        }
        for (int index = 0; index < 2; ++index) {
            void *busy = NULL;
            CHECK(pthread_join(others[index], &busy) == 0);
            met += *(unsigned long *)busy;
            free(busy);
        }
        nsrm_program_t program;
        program.size = sizeof program;
        CHECK(nsrm_get_program(task, &program) == NSRM_OK && program.step_count == 1);
    }
    /* Otherwise the threads never met, and nothing was shown. */
    CHECK(met > 0);
    free(task);
}

int main(int count, char **arguments) {
    pointers();
    sizes();
    order();
    scenes();
    sentences();
    images();
    /* Under valgrind threads take turns. */
    if (count < 2 || strcmp(arguments[1], "alone") != 0) {
        threads();
    }
    printf("%d failures\n", failures);
    return failures == 0 ? 0 : 1;
}
