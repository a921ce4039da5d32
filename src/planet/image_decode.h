// Images of tile servers: JPEG, PNG and WebP, told by their first bytes, whatever the server calls
// them. Sizes are checked before anything is unpacked, so that a small body cannot become a large
// picture. Any thread; nothing is trusted.
#ifndef PERIGEE_PLANET_IMAGE_DECODE_H
#define PERIGEE_PLANET_IMAGE_DECODE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

// What is wrong with a body, for a message.
enum { IMAGE_WHY_SIZE = 96 };

// Decodes into rgba: size x size x 4 bytes, R, G, B, A as they are coded, not multiplied by A, row
// 0 at the top. ERR_FORMAT, not logged, with the reason in `why`: no such image, another size,
// broken or cut short. ERR_MEMORY.
status image_decode(const void *data, size_t bytes, int size, uint8_t *rgba,
                    char why[IMAGE_WHY_SIZE]);

#endif
