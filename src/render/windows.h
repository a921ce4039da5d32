// The clipmap windows on the GPU: heights (R32F), normals (RG16 snorm, octahedral, ECEF), colour
// (sRGB RGBA8, night light in A), one layer of a texture array a level, all taken at creation. Main
// only.
#ifndef PERIGEE_RENDER_WINDOWS_H
#define PERIGEE_RENDER_WINDOWS_H

#include <epoxy/gl.h>

#include "clipmap/clipmap.h"
#include "gpu/upload.h"
#include "render/blocks.h"

struct windows;

typedef struct windows_params {
    struct pyramid *pyramid; // borrowed, like the pool
    struct pool *pool;
    int levels; // of heights
    int texels; // height samples across a level's ring: 128, 256, 512 or 1024
    size_t upload_bytes_frame;
    bool derive;                 // make levels below the data on the GPU, where it can be done
    bool fleeting;               // and do not keep those wholly below all data (fleeting.h)
    bool residuals;              // heights come as residuals where they can (residuals.h)
    size_t update_samples_frame; // of each layer; 0: as many as a window of one level has
} windows_params;

struct windows_counters {
    uint64_t samples;            // handed out in this frame
    uint64_t most_samples;       // of a layer in any frame that did not wait
    uint64_t heights, residuals; // samples of heights ever, and how many of them as residuals
    uint32_t heights_held_back;  // levels, as bits: see clipmap_counters.yielded
    uint32_t colors_held_back;
};

status windows_create(const windows_params *params, struct windows **out);
void windows_destroy(struct windows **windows);

// Text put before shaders that use the arrays (lib/layers.glsl).
const char *windows_defines(const struct windows *w);
GLuint windows_heights(const struct windows *w);
GLuint windows_normals(const struct windows *w);
GLuint windows_convexity(const struct windows *w);
GLuint windows_colors(const struct windows *w);
size_t windows_gpu_bytes(const struct windows *w);
// By how many levels finer than a ring's own level its heights are: what the windows' margin
// allows, so that the samples across a ring are never fewer than `texels`; -1 for 128.
double windows_lead(const struct windows *w);
int windows_color_levels(const struct windows *w);

// Sets the focus (geodetic, rad) and the finest rings whose own heights and colours are wanted;
// plans work.
void windows_move(struct windows *w, double lat, double lon, int last_height, int last_color);
// The finest level of heights wanted.
int windows_last_height(const struct windows *w);

// Are there fleeting levels, and how many others are kept.
bool windows_fleeting(const struct windows *w);
int windows_kept(const struct windows *w);
// A sweep through the fleeting levels: each is made from the one before, coarse to fine, and stays
// until the one after the next is made. windows_make() does so up to a level, which must not be
// coarser than one asked for before in this sweep; with its normals, which must be asked for level
// by level. False: the level is not there, nor are finer ones; the coarser have been made.
void windows_begin_sweep(struct windows *w);
bool windows_make(struct windows *w, int level, bool normals);

// Fills the coarsest level of every layer now, so that there is something to show from the first
// frame on. Blocks, at most timeout_s.
void windows_fill_coarsest(struct windows *w, double timeout_s);

// Uploads finished strips within the frame's budget and computes their normals. dt_s advances the
// fades; negative: fades end now. Returns the bytes uploaded since the call before.
size_t windows_pump(struct windows *w, double dt_s);

// True when the heights (and so placed vertices), or anything, changed since the call before.
bool windows_take_heights_changed(struct windows *w);
bool windows_take_changed(struct windows *w);
// A number that changes with what chain_height returns for a level of the rings.
uint64_t windows_heights_version(const struct windows *w, int level);

// Data is complete and no fade is under way.
bool windows_settled(const struct windows *w);
bool windows_complete(const struct windows *w);
// Complete or not, some of it stands in for data that could not be had, and will be filled again.
bool windows_provisional(const struct windows *w);
bool windows_wait(struct windows *w, double timeout_s);
// "height level 7: 3 strips" lines; returns their number.
int windows_missing(const struct windows *w, char *text, size_t size);

void windows_count(const struct windows *w, struct windows_counters *out);
// The window that a height level's texture holds, and its shape.
window windows_held(const struct windows *w, int level);
window_shape windows_height_samples(const struct windows *w);

void windows_fill_block(const struct windows *w, struct levels_block *block);

// Bounds of every height that chain_height can return for a level, with its blends to coarser
// levels.
void windows_height_bounds(const struct windows *w, int level, double *low, double *high);

#endif
