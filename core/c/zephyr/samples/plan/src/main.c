/* Parses a sentence in a thread's loop, a unit of work at a time. Untested: see zephyr/module.yml. */

#include <zephyr/kernel.h>
#include <zephyr/sys/printk.h>

#include "nsrm.h"

static nsrm_task_t task;
static const char sentence[] = "put the red block on the small green block";

int main(void) {
    nsrm_status_t status = nsrm_begin_parsing(&task, nsrm_tabletop(), sentence, sizeof sentence - 1);
    while (status == NSRM_PENDING) {
        status = nsrm_poll(&task);
        k_yield();
    }
    char text[256];
    if (status == NSRM_OK && nsrm_program_notation(&task, text, sizeof text, NULL) == NSRM_OK) {
        printk("%s\n", text);
    } else {
        printk("%s\n", nsrm_status_text(status));
    }
    return 0;
}
