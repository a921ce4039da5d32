#include "app/compare_equal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app/interrupt.h"
#include "app/size_search.h"
#include "base/log.h"

enum { TRIES = 10 };

#define SIZE_LOW        (1.0 / 32)
#define SIZE_HIGH       4.0
#define TRIANGLES_POWER 2.0 // of size
#define ERROR_POWER     -1.5

struct trial {
    struct compare_side *side;
    const struct compare_side *judge;
    struct compare_stage *stage;
    const perigee_camera *camera;
    uint64_t usual;             // triangles that size 1 draws, 0: not known yet
    bool one_size;              // the mode has no other
    perigee_view_params params; // of the view made last
};

// A mode warns once a view, and a search makes many.
static void set_log_level(const struct options *o, bool searching)
{
    log_set_level(o->verbose ? LOG_DEBUG : searching ? LOG_ERROR : o->quiet ? LOG_WARN : LOG_INFO);
}

static status set_size(struct trial *t, double size)
{
    t->params = t->stage->options.view_params;
    t->params.mode = (enum perigee_mode)t->side->mode;
    t->one_size = !perigee_view_params_resize(&t->params, size, t->usual);
    return compare_side_view(t->side, t->stage, &t->params);
}

static status measure_error(struct trial *t, double *value)
{
    compare_result r;
    status s = compare_side_render(t->side, t->stage, t->camera);
    if (!s) s = compare_side_judge(t->side, t->judge, t->stage, t->camera, NULL, &r);
    if (!s) *value = r.geometric_px.rank_999;
    return s;
}

static status measure(void *user, double size, double *value)
{
    struct trial *t = user;
    bool error = t->stage->options.equal == EQUAL_ERROR;
    *value = NAN;
    if (interrupt_requested()) return ERR_CANCELLED;
    if (t->one_size) return OK;
    status s = set_size(t, size);
    if (s) return s;
    s = error ? measure_error(t, value) : compare_side_frame(t->side, t->stage, t->camera);
    if (s) return s;
    perigee_stats stats;
    perigee_view_get_stats(t->side->view, &stats);
    if (!t->usual) t->usual = stats.triangles_drawn;
    if (!error) *value = (double)stats.triangles_drawn;
    log_debug("%s: size %.4g: %llu triangles, %.4g, GPU %.1f MiB", t->side->name, size,
              (unsigned long long)stats.triangles_drawn, *value, (double)stats.gpu_bytes / 0x1p20);
    return OK;
}

status compare_equal_goal(struct compare_side *side, const struct compare_side *judge,
                          struct compare_stage *stage, const perigee_camera *camera, double *goal)
{
    struct trial t = {.side = side, .judge = judge, .stage = stage, .camera = camera};
    set_log_level(&stage->options, true);
    status s = measure(&t, 1, goal);
    set_log_level(&stage->options, false);
    if (!s && stage->options.equal == EQUAL_ERROR) *goal = fmax(*goal, COMPARE_EQUAL_LEAST_PX);
    return s;
}

// Options of the mesh, as far as resizing set them.
static void describe(const perigee_view_params *now, const perigee_view_params *before, char *text,
                     size_t size)
{
    int n = 0;
    text[0] = '\0';
    if (now->azimuth_steps != before->azimuth_steps)
        n += snprintf(text + n, size - (size_t)n,
                      "--azimuth-steps %d --rings %d --ring-spacing %.4g", now->azimuth_steps,
                      now->rings_per_level, now->ring_spacing_px);
    if (now->planar_n != before->planar_n)
        n += snprintf(text + n, size - (size_t)n,
                      "--planar-n %d --planar-form 2004 --planar-triangles %u", now->planar_n,
                      (unsigned)now->planar_triangles);
    if (now->grid_rows != before->grid_rows)
        n +=
            snprintf(text + n, size - (size_t)n, "--grid %dx%d", now->grid_rows, now->grid_columns);
    if (now->texels != before->texels)
        snprintf(text + n, size - (size_t)n, " --texels %d", now->texels);
}

status compare_equal_choose(struct compare_side *side, const struct compare_side *judge,
                            struct compare_stage *stage, const perigee_camera *camera, double goal,
                            compare_size *out)
{
    struct trial t = {.side = side, .judge = judge, .stage = stage, .camera = camera};
    bool error = stage->options.equal == EQUAL_ERROR;
    size_search_params params = {.low = SIZE_LOW,
                                 .high = SIZE_HIGH,
                                 .goal = goal,
                                 .tolerance = COMPARE_EQUAL_TOLERANCE,
                                 .exponent = error ? ERROR_POWER : TRIANGLES_POWER,
                                 .tries = TRIES,
                                 .measure = measure,
                                 .user = &t};
    size_search_result found;
    set_log_level(&stage->options, true);
    status s = size_search(&params, &found);
    set_log_level(&stage->options, false);
    if (!s) s = set_size(&t, found.size);
    if (s) return s;
    *out = (compare_size){.size = found.size, .met = found.met};
    describe(&t.params, &stage->options.view_params, out->options, sizeof out->options);
    return OK;
}
