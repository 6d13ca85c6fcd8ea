/* All that runs in a control loop, and nothing else: tests/tests/c_interface/ looks at what is linked. */

#include "nsrm.h"

static nsrm_task_t task;
static nsrm_observer_t observer;
static nsrm_scene_t scene;
static nsrm_plan_t plan;
static nsrm_program_t program;
static nsrm_refusal_t refusal;
static nsrm_detection_t detection;
static uint8_t pixels[3 * 64 * 64];

int main(int count, char **arguments) {
    const nsrm_camera_t camera = {
        64, 64, 60.0f, 60.0f, 32.0f, 32.0f, {0.5f, 0.0f, 1.0f}, {1.0f, 0.0f, 0.0f, 0.0f},
    };
    const nsrm_image_t image = {pixels, sizeof pixels, 64, 64, 3 * 64};
    const nsrm_model_t *model = nsrm_tabletop();
    plan.size = sizeof plan;
    program.size = sizeof program;
    refusal.size = sizeof refusal;
    nsrm_status_t status =
        nsrm_observe_begin(&observer, model, &image, &camera, &detection, (size_t)count, 1, 2);
    while (status == NSRM_PENDING) {
        status = nsrm_observe_poll(&observer, &scene);
    }
    status = nsrm_begin(&task, model, &scene, arguments[0], 1);
    while (status == NSRM_PENDING) {
        status = nsrm_poll(&task);
    }
    nsrm_get_plan(&task, &plan);
    nsrm_get_program(&task, &program);
    nsrm_get_refusal(&task, &refusal);
    status = nsrm_begin_grounding(&task, &scene, 0);
    while (status == NSRM_PENDING) {
        status = nsrm_poll(&task);
    }
    return status == NSRM_OK ? 0 : 1;
}
