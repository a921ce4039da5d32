#include "app/compare_files.h"

#include <string.h>

#include "base/log.h"

enum { WIDTH = 1280, HEIGHT = 960 };

bool compare_side_is_file(const struct compare_side *side)
{
    return side->mode < 0;
}

static status refuse_file(const struct compare_side *side, const char *what)
{
    log_error("%s: %s", side->name, what);
    return ERR_ARGUMENT;
}

// What two cameras differ in, NULL: nothing. Files keep all bits.
static const char *camera_difference(const perigee_camera *a, const perigee_camera *b)
{
    if (a->lat_deg != b->lat_deg) return "camera.lat";
    if (a->lon_deg != b->lon_deg) return "camera.lon";
    if (a->alt_m != b->alt_m) return "camera.alt";
    if (a->heading_deg != b->heading_deg) return "camera.heading";
    if (a->pitch_deg != b->pitch_deg) return "camera.pitch";
    if (a->roll_deg != b->roll_deg) return "camera.roll";
    return a->fov_deg != b->fov_deg ? "camera.fov" : NULL;
}

static status take_file(const struct compare_side *side, struct compare_stage *stage,
                        perigee_camera *camera)
{
    const struct options *o = &stage->options;
    const image_exr_file *p = &side->picture;
    if (stage->samples > 1) return refuse_file(side, "has its colours: no --samples");
    if (!p->has_camera) return refuse_file(side, "no attributes camera.lat and so on");
    if (o->path)
        return refuse_file(side, "a picture of one camera cannot be compared along --path");
    if (o->views)
        return refuse_file(side, "a picture of one camera cannot be compared with --views");
    if (options_camera_given(o))
        return refuse_file(side, "the camera is that of the file: no --camera, --lat and so on");
    if (o->width && (o->width != p->width || o->height != p->height)) {
        log_error("--size %dx%d: %s has %dx%d pixels", o->width, o->height, side->name, p->width,
                  p->height);
        return ERR_ARGUMENT;
    }
    *camera = p->camera;
    stage->width = p->width;
    stage->height = p->height;
    return OK;
}

static status check_pair(const struct compare_side *a, const struct compare_side *b)
{
    if (!compare_side_is_file(a) || !compare_side_is_file(b)) return OK;
    if (a->picture.width != b->picture.width || a->picture.height != b->picture.height) {
        log_error("%s has %dx%d pixels, %s %dx%d", a->name, a->picture.width, a->picture.height,
                  b->name, b->picture.width, b->picture.height);
        return ERR_ARGUMENT;
    }
    const char *differs = camera_difference(&a->picture.camera, &b->picture.camera);
    if (differs) {
        log_error("%s and %s: not of one camera: they differ in %s", a->name, b->name, differs);
        return ERR_ARGUMENT;
    }
    return OK;
}

status compare_files_open(const char *const *names, int count, struct compare_side *sides,
                          struct compare_stage *stage, bool *files, perigee_camera *camera)
{
    const struct options *o = &stage->options;
    status s = OK;
    *files = false;
    stage->width = o->width ? o->width : WIDTH;
    stage->height = o->height ? o->height : HEIGHT;
    stage->samples = o->samples ? o->samples : 1;
    for (int i = 0; i < count && !s; i++) {
        s = compare_side_open(names[i], &sides[i]);
        if (s || !compare_side_is_file(&sides[i])) continue;
        s = take_file(&sides[i], stage, camera);
        *files = true;
    }
    if (!s) s = reference_check_options(o, stage->width, stage->height, stage->samples);
    for (int i = 1; i < count && !s; i++) s = check_pair(&sides[0], &sides[i]);
    return s;
}

void compare_files_check_planet(const struct compare_side *sides, int count, const char *planet)
{
    for (int i = 0; i < count; i++) {
        const char *name = sides[i].picture.planet;
        if (compare_side_is_file(&sides[i]) && planet[0] && strcmp(name, planet) != 0)
            log_warn("%s: a picture of '%s', not of '%s'", sides[i].name, name, planet);
    }
}
