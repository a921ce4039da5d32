#include "render/params.h"

#include <math.h>

#include "base/log.h"
#include "clipmap/clipmap.h"
#include "render/cells.h"
#include "render/geometry.h"

struct quality {
    int azimuth_steps, rings_per_level, texels;
    double spacing_px;
    enum perigee_filter filter;
    double error_px; // bound of 99.9 % of all pixels in the views of tests/ACCURACY.md, 3
};

// What is chosen from, from cheap to dear (bench/RESULTS.md has the curves); and the paper's
// (Clasen & Hege 2006, 5: 512 x 20, textures n/4).
static const struct quality BY_COST[] = {{512, 48, 256, 8, PERIGEE_FILTER_SHARP, 2.7},
                                         {640, 64, 256, 7, PERIGEE_FILTER_SHARP, 2},
                                         {1024, 80, 512, 5, PERIGEE_FILTER_SHARP, 1.4},
                                         {1024, 112, 1024, 4, PERIGEE_FILTER_SHARP, 0.9}};
static const struct quality PAPER = {512, 20, 128, -1, PERIGEE_FILTER_EMULATED, 6};

static const struct quality *const QUALITIES[] = {
    [PERIGEE_QUALITY_DEFAULT] = &BY_COST[1],
    [PERIGEE_QUALITY_LOW] = &BY_COST[0],
    [PERIGEE_QUALITY_HIGH] = &BY_COST[3],
    [PERIGEE_QUALITY_PAPER] = &PAPER,
};

enum {
    COUNT = sizeof QUALITIES / sizeof *QUALITIES,
    CHOICES = sizeof BY_COST / sizeof *BY_COST,
    DEFAULT_LEVELS = 24,
    TEXELS_MAX = 1024,
    MAX_THREADS = 256
};

static status choose(const perigee_view_params *p, const struct quality **out)
{
    *out = QUALITIES[p->quality];
    if (p->error_px == 0) return OK;
    for (int i = 0; i < CHOICES; i++) {
        *out = &BY_COST[i];
        if (BY_COST[i].error_px <= p->error_px) return OK;
    }
    log_error("no setting keeps the error below %g pixels; the finest keeps %g", p->error_px,
              BY_COST[CHOICES - 1].error_px);
    return ERR_ARGUMENT;
}

static status complete_rings(perigee_view_params *p)
{
    const struct quality *q;
    if ((int)p->quality < 0 || (int)p->quality >= COUNT || !(p->error_px >= 0)) {
        log_error("impossible quality: %d, error of %g pixels", (int)p->quality, p->error_px);
        return ERR_ARGUMENT;
    }
    status s = choose(p, &q);
    if (s) return s;
    if (!p->azimuth_steps) p->azimuth_steps = q->azimuth_steps;
    if (!p->rings_per_level) p->rings_per_level = q->rings_per_level;
    if (!p->texels) p->texels = q->texels;
    if (p->ring_spacing_px == 0) p->ring_spacing_px = q->spacing_px;
    if (!p->filter) p->filter = q->filter;
    return OK;
}

static status check(const perigee_view_params *p)
{
    const char *wrong = NULL;
    int value = 0;
    if (p->azimuth_steps < 64 || p->azimuth_steps > 4096 || p->azimuth_steps % 64)
        wrong = "azimuth steps (a multiple of 64 up to 4096)", value = p->azimuth_steps;
    else if (p->rings_per_level < 2 || p->rings_per_level > 512 || p->rings_per_level % CELL_BANDS)
        wrong = "rings a level (an even number up to 512)", value = p->rings_per_level;
    else if (p->texels < 128 || p->texels > TEXELS_MAX || (p->texels & (p->texels - 1)))
        wrong = "height samples across a ring (128, 256, 512 or 1024)", value = p->texels;
    else if (p->levels < 3 || p->levels > CLIPMAP_MAX_LEVELS)
        wrong = "levels (3 to 24)", value = p->levels;
    else if (p->last_level < 0 || p->last_level >= p->levels)
        wrong = "last level", value = p->last_level;
    else if (p->first_level < 0 || p->first_level >= p->levels ||
             (p->last_level && p->first_level > p->last_level))
        wrong = "first level", value = p->first_level;
    else if (p->threads < 0 || p->threads > MAX_THREADS)
        wrong = "number of threads (up to 256)", value = p->threads;
    else if ((int)p->transform < 0 || p->transform > PERIGEE_TRANSFORM_BLEND)
        wrong = "transform", value = (int)p->transform;
    else if ((int)p->filter < 0 || p->filter > PERIGEE_FILTER_HARDWARE)
        wrong = "height filter", value = (int)p->filter;
    else if (!geometry_mode_find(p->mode)) wrong = "mode", value = (int)p->mode;
    if (!wrong) return OK;
    log_error("impossible %s: %d", wrong, value);
    return ERR_ARGUMENT;
}

status params_complete(perigee_view_params *p)
{
    if (!p->levels) p->levels = DEFAULT_LEVELS;
    p->planar_memory_free &= p->mode == PERIGEE_MODE_PLANAR;
    p->planar_residuals &= p->mode == PERIGEE_MODE_PLANAR;
    p->gpu_synthesis |= p->planar_memory_free;
    if (!p->upload_bytes_frame) p->upload_bytes_frame = (size_t)4 << 20;
    status s = complete_rings(p);
    if (!s) s = check(p);
    if (s) return s;
    const struct geometry_mode *mode = geometry_mode_find(p->mode);
    return mode->complete ? mode->complete(p) : OK;
}

int params_texels_for(double size)
{
    int texels = BY_COST[1].texels;
    while (texels < TEXELS_MAX && BY_COST[1].texels * size > texels * 1.2) texels *= 2;
    return texels;
}
