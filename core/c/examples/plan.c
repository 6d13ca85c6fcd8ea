/* Plans a sentence in a scene, and prints the program and its sub-goals, or why it is refused.
 *
 *     plan "put the red block on the small green block"
 *
 * Exit code 2 if it is refused. */

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "nsrm.h"
#include "table.h"

/* No memory of the library's own: these may lie anywhere. */
static uint8_t pixels[3 * TABLE_WIDTH * TABLE_HEIGHT];
static nsrm_observer_t observer;
static nsrm_task_t task;
static nsrm_scene_t scene;
static nsrm_plan_t plan;

/* What went wrong, on standard error. */
static int fail(const char *what, nsrm_status_t status) {
    fprintf(stderr, "error: %s: %s\n", what, nsrm_status_text(status));
    return 1;
}

int main(int count, char **arguments) {
    const char *sentence =
        count > 1 ? arguments[1] : "put the small green block to the right of the red block";
    const nsrm_model_t *model = nsrm_tabletop();

    nsrm_detection_t detections[TABLE_BLOCKS];
    table_look(pixels, detections);
    const nsrm_image_t image = {
        pixels, sizeof pixels, TABLE_WIDTH, TABLE_HEIGHT, (size_t)3 * TABLE_WIDTH,
    };
    nsrm_status_t status = nsrm_observe(&observer, model, &image, &TABLE_CAMERA, detections,
                                        TABLE_BLOCKS, 1, 0, &scene);
    if (status != NSRM_OK) {
        return fail("observing", status);
    }

    char text[1024];
    plan.size = sizeof plan;
    status = nsrm_plan(&task, model, &scene, sentence, strlen(sentence), &plan);
    if (status == NSRM_REFUSED) {
        nsrm_refusal_message(&task, text, sizeof text, NULL);
        fprintf(stderr, "refused: %s\n", text);
        return 2;
    }
    if (status != NSRM_OK) {
        return fail("planning", status);
    }
    nsrm_program_notation(&task, text, sizeof text, NULL);
    printf("%s\n", text);
    for (uint32_t index = 0; index < plan.count; ++index) {
        const nsrm_sub_goal_t *goal = &plan.sub_goals[index];
        printf("object %" PRIu32 " to x %.3f y %.3f z %.3f m\n", goal->object.object,
               (double)goal->position[0], (double)goal->position[1], (double)goal->position[2]);
    }
    printf("confidence %.2f\n", (double)plan.confidence);
    return 0;
}
