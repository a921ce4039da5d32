// Two pictures of one size in one: the left half of the first beside the right half of the second,
// a white line between, and in the lowest rows the amplified difference of the two. Main only.
#ifndef PERIGEE_GPU_SPLIT_H
#define PERIGEE_GPU_SPLIT_H

#include "gpu/target.h"

typedef struct gpu_split {
    gpu_target pictures[2]; // RGBA8, drawn by the caller
    GLuint program, empty_array;
} gpu_split;

// Pictures come with the first resize. ERR_GPU, logged.
status gpu_split_init(gpu_split *s);
void gpu_split_deinit(gpu_split *s);

// Makes the pictures fit; nothing when they do already. ERR_GPU, logged; then there are none.
status gpu_split_resize(gpu_split *s, int width, int height);

// Draws over (0, 0, width, height) of `framebuffer`, and leaves it bound and no program in use. The
// lowest `difference_px` rows (0 to the height) show gain * |first - second| of the encoded
// colours.
void gpu_split_draw(const gpu_split *s, GLuint framebuffer, int difference_px, float gain);

// The same as 8-bit RGB, top row first: width * height * 3 bytes. Waits for the GPU.
status gpu_split_read(const gpu_split *s, int difference_px, float gain, void *rgb);

#endif
