#include "render/geometry.h"

static const struct geometry_mode *const MODES[] = {
    [PERIGEE_MODE_SPHERICAL] = &geometry_spherical,
    [PERIGEE_MODE_PLANAR] = &geometry_planar,
    [PERIGEE_MODE_GRID] = &geometry_grid,
};

enum { COUNT = sizeof MODES / sizeof *MODES };

const struct geometry_mode *geometry_mode_find(enum perigee_mode mode)
{
    return (int)mode >= 0 && (int)mode < COUNT ? MODES[mode] : NULL;
}

const char *perigee_mode_name(enum perigee_mode mode)
{
    const struct geometry_mode *m = geometry_mode_find(mode);
    return m ? m->name : NULL;
}

bool perigee_view_params_resize(perigee_view_params *params, double size, uint64_t triangles)
{
    const struct geometry_mode *m = geometry_mode_find(params->mode);
    if (!m || !m->resize || !(size > 0)) return false;
    m->resize(params, size, triangles);
    return true;
}

status geometry_create(enum perigee_mode mode, const geometry_params *params, struct geometry **out)
{
    const struct geometry_mode *m = geometry_mode_find(mode);
    *out = NULL;
    status s = m->create(params, out);
    if (!s) (*out)->mode = m;
    return s;
}

void geometry_destroy(struct geometry **geometry)
{
    if (*geometry) (*geometry)->mode->destroy(*geometry);
    *geometry = NULL;
}
