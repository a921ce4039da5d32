#include "app/compare_output.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/output_file.h"
#include "base/log.h"

// PREFIX.exr, or PREFIX-00012.exr of a flight.
static status output_name(const struct options *o, bool flight, int frame, const char *extension,
                          char path[OUTPUT_PATH_SIZE])
{
    const char *prefix = o->output;
    int length = flight ? snprintf(path, OUTPUT_PATH_SIZE, "%s-%05d%s", prefix, frame, extension)
                        : snprintf(path, OUTPUT_PATH_SIZE, "%s%s", prefix, extension);
    if (length < OUTPUT_PATH_SIZE - 16) return OK;
    log_error("-o %.80s...: too long", prefix);
    return ERR_ARGUMENT;
}

static status write_map(const compare_head *head, const compare_maps *maps, const char *path)
{
    static const struct image_text texts[] = {{"Software", "Perigee"}};
    int width = head->width, height = head->height;
    uint8_t *rgb = calloc((size_t)width * (size_t)height, 3);
    status s = ERR_MEMORY;
    if (rgb) {
        compare_picture_map(maps, width, height, rgb);
        s = image_png_write(path, width, height, rgb, texts, 1);
    } else log_error("%s: out of memory", path);
    free(rgb);
    return s;
}

static status write_difference(const struct compare_stage *stage, const compare_head *head,
                               const compare_row *row, const compare_maps *maps, const char *path)
{
    size_t pixels = row->result.pixels;
    float *kind = calloc(pixels, sizeof *kind);
    if (!kind) {
        log_error("%s: out of memory", path);
        return ERR_MEMORY;
    }
    for (size_t i = 0; i < pixels; i++) kind[i] = maps->kind[i];
    const image_exr_plane planes[] = {{"depth_m", maps->depth_m},
                                      {"geometric_px", maps->geometric_px},
                                      {"kind", kind},
                                      {"silhouette_px", maps->silhouette_px}};
    image_exr about = {.width = stage->width,
                       .height = stage->height,
                       .camera = row->camera,
                       .planet = head->planet,
                       .attribution = stage->session.info.attribution};
    status s = image_exr_write_planes(path, &about, planes, sizeof planes / sizeof planes[0]);
    free(kind);
    return s;
}

status compare_output_row(const struct compare_stage *stage, const compare_head *head,
                          const struct compare_side sides[2], const compare_row *row,
                          const compare_maps *maps, double *worst)
{
    const struct options *o = &stage->options;
    char path[OUTPUT_PATH_SIZE];
    compare_picture a = compare_side_planes(&sides[0]), b = compare_side_planes(&sides[1]);
    double error = row->result.geometric_px.rank_999;
    status s = OK;
    if (o->picture && (row->frame == 0 || error > *worst)) {
        s = compare_picture_write(o->picture, head, row, &a, &b, maps);
        *worst = isnan(error) ? -1 : error;
    }
    if (!o->output) return s;
    if (!s) s = output_name(o, head->flight, row->frame, ".exr", path);
    if (!s) s = write_difference(stage, head, row, maps, path);
    if (!s) s = output_name(o, head->flight, row->frame, ".png", path);
    return s ? s : write_map(head, maps, path);
}

status compare_output_check(const struct options *o)
{
    const char *const files[] = {o->csv, o->json_file, o->picture};
    status s = OK;
    if (o->picture && !output_has_extension(o->picture, ".png")) {
        log_error("--picture %s: not a .png", o->picture);
        return ERR_ARGUMENT;
    }
    for (int i = 0; i < 3 && !s; i++)
        if (files[i]) s = output_check(files[i]);
    char probe[OUTPUT_PATH_SIZE];
    if (s || !o->output) return s;
    if (snprintf(probe, sizeof probe, "%s.exr", o->output) >= (int)sizeof probe - 16) {
        log_error("-o %.80s...: too long", o->output);
        return ERR_ARGUMENT;
    }
    snprintf(probe + strlen(o->output), 5, ".png");
    if (o->picture && strcmp(probe, o->picture) == 0) {
        log_error("-o %s: its error map %s would be the --picture", o->output, probe);
        return ERR_ARGUMENT;
    }
    return output_check(probe);
}
