/* A table as a camera sees it, for the examples: coloured squares instead of blocks, and where they
 * are. A robot has a camera and a detector instead. */

#ifndef TABLE_H
#define TABLE_H

#include <string.h>

#include "nsrm.h"

#define TABLE_WIDTH 640
#define TABLE_HEIGHT 480
#define TABLE_BLOCKS 5

/* Straight above the table, at a height of one metre. */
static const nsrm_camera_t TABLE_CAMERA = {
    TABLE_WIDTH,
    TABLE_HEIGHT,
    600.0f,
    600.0f,
    320.0f,
    240.0f,
    {0.5f, 0.0f, 1.0f},
    {1.0f, 0.0f, 0.0f, 0.0f},
};

/* Red, green, blue, magenta and yellow, from left to right; green and magenta are small. */
static const uint8_t TABLE_COLORS[TABLE_BLOCKS][3] = {
    {204, 23, 23}, {26, 153, 41}, {23, 51, 204}, {204, 26, 184}, {230, 204, 20},
};

/* Draws the image and says where the blocks are. */
static inline void table_look(uint8_t *pixels, nsrm_detection_t *detections) {
    memset(pixels, 128, (size_t)3 * TABLE_WIDTH * TABLE_HEIGHT);
    for (uint32_t index = 0; index < TABLE_BLOCKS; ++index) {
        const uint32_t side = index % 2 == 0 ? 40u : 28u;
        const uint32_t left = 170u + 60u * index;
        const uint32_t top = 200u;
        for (uint32_t row = top; row < top + side; ++row) {
            for (uint32_t column = left; column < left + side; ++column) {
                memcpy(&pixels[3u * (row * TABLE_WIDTH + column)], TABLE_COLORS[index], 3);
            }
        }
        nsrm_detection_t *detection = &detections[index];
        detection->id = index + 1u;
        detection->visible[0] = (float)left / (float)TABLE_WIDTH;
        detection->visible[1] = (float)top / (float)TABLE_HEIGHT;
        detection->visible[2] = (float)(left + side) / (float)TABLE_WIDTH;
        detection->visible[3] = (float)(top + side) / (float)TABLE_HEIGHT;
        memcpy(detection->location, detection->visible, sizeof detection->visible);
        detection->location[4] = index % 2 == 0 ? 0.96f : 0.97f;
    }
}

#endif
