#include "app/window_views.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "gpu/split.h"

struct side {
    perigee_view *view;
    int mode, tried; // tried: asked for last, refused or not
};

struct window_views {
    perigee_planet *planet;
    perigee_view_params params;
    struct side sides[2];
    gpu_split split; // while there is a second side
    int difference;
};

// From below, in thirds of the rows.
static const int difference_thirds[] = {1, 3, 0};
enum { DIFFERENCES = sizeof difference_thirds / sizeof difference_thirds[0] };

static int next_mode(int mode)
{
    return perigee_mode_name((enum perigee_mode)(mode + 1)) ? mode + 1 : 0;
}

// The old view goes when the new one is there.
static status set_mode(struct window_views *v, struct side *side, int mode)
{
    perigee_view_params params = v->params;
    perigee_view *view;
    side->tried = mode;
    if (side->view && mode == side->mode) return OK;
    params.mode = (enum perigee_mode)mode;
    status s = (status)perigee_view_create(v->planet, &params, &view);
    if (s) return s;
    perigee_view_destroy(&side->view);
    *side = (struct side){view, mode, mode};
    return OK;
}

status window_views_create(perigee_planet *planet, const perigee_view_params *params,
                           struct window_views **out)
{
    struct window_views *v = NEW(struct window_views);
    v->planet = planet;
    if (params) v->params = *params;
    status s = set_mode(v, &v->sides[0], (int)v->params.mode);
    if (s) window_views_destroy(&v);
    *out = v;
    return s;
}

static void close_split(struct window_views *v)
{
    perigee_view_destroy(&v->sides[1].view);
    gpu_split_deinit(&v->split);
}

void window_views_destroy(struct window_views **views)
{
    struct window_views *v = *views;
    if (!v) return;
    if (window_views_is_split(v)) close_split(v);
    perigee_view_destroy(&v->sides[0].view);
    free(v);
    *views = NULL;
}

bool window_views_is_split(const struct window_views *v)
{
    return v->sides[1].view != NULL;
}

status window_views_next_mode(struct window_views *v)
{
    struct side *side = &v->sides[window_views_is_split(v)];
    return set_mode(v, side, next_mode(side->tried));
}

status window_views_toggle_split(struct window_views *v, int width, int height)
{
    if (window_views_is_split(v)) {
        close_split(v);
        return OK;
    }
    status s = gpu_split_init(&v->split);
    if (!s) s = gpu_split_resize(&v->split, width, height);
    if (!s) s = set_mode(v, &v->sides[1], next_mode(v->sides[0].mode));
    if (s) close_split(v);
    return s;
}

void window_views_next_difference(struct window_views *v)
{
    v->difference = (v->difference + 1) % DIFFERENCES;
}

double window_views_difference(const struct window_views *v)
{
    return window_views_is_split(v) ? difference_thirds[v->difference] / 3.0 : 0;
}

const char *window_views_mode(const struct window_views *v, int side)
{
    const struct side *s = &v->sides[side];
    return s->view ? perigee_mode_name((enum perigee_mode)s->mode) : NULL;
}

static status aim(perigee_view *view, const perigee_camera *camera, double unix_time_s)
{
    status s = (status)perigee_view_set_camera(view, camera);
    if (isnan(unix_time_s)) perigee_view_set_time_noon(view);
    else if (!s) s = (status)perigee_view_set_time(view, unix_time_s);
    return s;
}

static status render_side(struct window_views *v, int side, const perigee_camera *camera,
                          double unix_time_s, int width, int height, GLuint framebuffer)
{
    perigee_view *view = v->sides[side].view;
    status s = aim(view, camera, unix_time_s);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    return s ? s : (status)perigee_view_render(view, width, height);
}

// The pictures of both halves, whole.
static status render_split(struct window_views *v, const perigee_camera *camera, double unix_time_s,
                           int width, int height)
{
    status s = gpu_split_resize(&v->split, width, height);
    for (int i = 0; !s && i < 2; i++)
        s = render_side(v, i, camera, unix_time_s, width, height, v->split.pictures[i].framebuffer);
    return s;
}

static int difference_px(const struct window_views *v, int height)
{
    return height * difference_thirds[v->difference] / 3;
}

status window_views_render(struct window_views *v, const perigee_camera *camera, double unix_time_s,
                           int width, int height, unsigned framebuffer)
{
    if (!window_views_is_split(v))
        return render_side(v, 0, camera, unix_time_s, width, height, framebuffer);
    status s = render_split(v, camera, unix_time_s, width, height);
    if (!s) gpu_split_draw(&v->split, framebuffer, difference_px(v, height), WINDOW_VIEWS_GAIN);
    return s;
}

status window_views_picture(struct window_views *v, const perigee_camera *camera,
                            double unix_time_s, int width, int height, uint8_t *rgb)
{
    if (!window_views_is_split(v)) {
        status s = aim(v->sides[0].view, camera, unix_time_s);
        return s ? s : (status)perigee_view_render_image(v->sides[0].view, width, height, 2, rgb);
    }
    status s = render_split(v, camera, unix_time_s, width, height);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    return s ? s : gpu_split_read(&v->split, difference_px(v, height), WINDOW_VIEWS_GAIN, rgb);
}

perigee_stats window_views_stats(const struct window_views *v, int side)
{
    perigee_stats stats = {0};
    if (v->sides[side].view) perigee_view_get_stats(v->sides[side].view, &stats);
    return stats;
}

bool window_views_need_redraw(const struct window_views *v)
{
    return window_views_stats(v, 0).needs_redraw || window_views_stats(v, 1).needs_redraw;
}

int window_views_missing(const struct window_views *v, char *text, size_t size)
{
    int count = perigee_view_missing(v->sides[0].view, text, size);
    if (!window_views_is_split(v)) return count;
    char other[512];
    int more =
        perigee_view_missing(v->sides[1].view, count ? other : text, count ? sizeof other : size);
    return count + more;
}

bool window_views_pick(struct window_views *v, double x_px, double y_px, double *lat_deg,
                       double *lon_deg, double *height_m)
{
    return !perigee_view_pick(v->sides[0].view, x_px, y_px, lat_deg, lon_deg, height_m);
}
