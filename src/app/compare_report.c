#include "app/compare_report.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/camera_string.h"
#include "app/output_file.h"
#include "base/log.h"

#define FORMULA "10 log10(1 / MSE), MSE of R, G, B sRGB-encoded in [0, 1]"

struct measure {
    const char *title, *name;
    size_t offset; // of a compare_stat in compare_result
};

static const struct measure measures[] = {
    {"geometric error, px", "geometric_px", offsetof(compare_result, geometric_px)},
    {"  silhouettes too, px", "geometric_all_px", offsetof(compare_result, geometric_all_px)},
    {"distance, pixel sizes", "distance_px", offsetof(compare_result, distance_px)},
    {"depth error, m", "depth_m", offsetof(compare_result, depth_m)},
    {"depth error, relative", "depth_relative", offsetof(compare_result, depth_relative)},
    {"limb displaced, px", "limb_px", offsetof(compare_result, limb_px)},
    {"ridges displaced, px", "ridge_px", offsetof(compare_result, ridge_px)},
};

enum { MEASURES = sizeof measures / sizeof measures[0] };

struct count {
    const char *name;
    size_t offset; // of a size_t in compare_result
};

static const struct count counts[] = {
    {"pixels", offsetof(compare_result, pixels)},
    {"sky", offsetof(compare_result, sky)},
    {"ground", offsetof(compare_result, ground)},
    {"silhouette", offsetof(compare_result, silhouette)},
    {"missing", offsetof(compare_result, missing)},
    {"missing_inside", offsetof(compare_result, missing_inside)},
    {"extra", offsetof(compare_result, extra)},
    {"extra_outside", offsetof(compare_result, extra_outside)},
    {"edges_a", offsetof(compare_result, edges_a)},
    {"edges_b", offsetof(compare_result, edges_b)},
    {"edges_only_a", offsetof(compare_result, edges_only_a)},
    {"edges_only_b", offsetof(compare_result, edges_only_b)},
    {"colors", offsetof(compare_result, colors)},
};

enum { COUNTS = sizeof counts / sizeof counts[0] };

static const compare_stat *stat_of(const compare_result *r, int i)
{
    return (const compare_stat *)((const char *)r + measures[i].offset);
}

static size_t count_of(const compare_result *r, int i)
{
    return *(const size_t *)((const char *)r + counts[i].offset);
}

// The numbers of a statistic, the same everywhere.
static const char *const number_names[] = {"mean", "rms", "median", "p999", "max", "lat", "lon"};

enum { NUMBERS = sizeof number_names / sizeof number_names[0] };

static void numbers_of(const compare_stat *s, double out[NUMBERS])
{
    const double numbers[NUMBERS] = {s->mean, s->rms,     s->median, s->rank_999,
                                     s->max,  s->lat_deg, s->lon_deg};
    memcpy(out, numbers, sizeof numbers);
}

static void format_stat(const compare_result *r, int i, char *text, size_t size)
{
    const compare_stat *s = stat_of(r, i);
    char place[64] = "";
    if (!isnan(s->lat_deg)) snprintf(place, sizeof place, "  %.6f, %.6f", s->lat_deg, s->lon_deg);
    if (s->count == 0) snprintf(text, size, "%-24s nothing to measure", measures[i].title);
    else
        snprintf(text, size, "%-24s %10.4g %10.4g %10.4g %10.4g %10.4g  %5d,%5d%s",
                 measures[i].title, s->mean, s->rms, s->median, s->rank_999, s->max, s->x, s->y,
                 place);
}

static void format_color(const compare_result *r, char *text, size_t size)
{
    if (r->colors == 0) snprintf(text, size, "colour: not compared");
    else if (r->mse == 0) snprintf(text, size, "colour: equal in %zu pixels", r->colors);
    else snprintf(text, size, "colour PSNR %.2f dB = " FORMULA ": %.4g", r->psnr_db, r->mse);
}

int compare_report_lines(const compare_row *row, char lines[COMPARE_LINES][COMPARE_LINE_SIZE])
{
    const compare_result *r = &row->result;
    int n = 0;
    snprintf(lines[n++], COMPARE_LINE_SIZE,
             "ground %zu  silhouette %zu  sky %zu  missing %zu (%zu inside the limb)  extra %zu "
             "(%zu outside)",
             r->ground, r->silhouette, r->sky, r->missing, r->missing_inside, r->extra,
             r->extra_outside);
    snprintf(lines[n++], COMPARE_LINE_SIZE, "%-24s %10s %10s %10s %10s %10s  %11s  %s", "", "mean",
             "rms", "median", "99.9 %", "maximum", "at pixel", "lat, lon there");
    for (int i = 0; i < MEASURES; i++) format_stat(r, i, lines[n++], COMPARE_LINE_SIZE);
    snprintf(lines[n++], COMPARE_LINE_SIZE,
             "edges: %zu in b, %zu of them not in a; %zu in a, %zu "
             "of them not in b",
             r->edges_b, r->edges_only_b, r->edges_a, r->edges_only_a);
    format_color(r, lines[n++], COMPARE_LINE_SIZE);
    return n;
}

void compare_report_print(FILE *f, const compare_head *head, const compare_row *row)
{
    char camera[CAMERA_STRING_SIZE], lines[COMPARE_LINES][COMPARE_LINE_SIZE];
    camera_string_format(&row->camera, camera, sizeof camera);
    fprintf(f, "a: %s\nb: %s", head->a, head->b);
    const char *between = head->bicubic ? ", bicubic" : "";
    if (row->zoom_low == row->zoom_high)
        fprintf(f, " (heights of zoom %g%s)", row->zoom_low, between);
    else if (!isnan(row->zoom_low))
        fprintf(f, " (heights of zoom %g to %g%s)", row->zoom_low, row->zoom_high, between);
    fprintf(f, "\n%s%s%d x %d px, camera %s\n", head->planet, head->planet[0] ? ", " : "",
            head->width, head->height, camera);
    int count = compare_report_lines(row, lines);
    for (int i = 0; i < count; i++) fprintf(f, "%s\n", lines[i]);
    if (row->result.colors && head->color_note[0]) fprintf(f, "%s\n", head->color_note);
}

void compare_report_line(FILE *f, const compare_row *row)
{
    const compare_result *r = &row->result;
    if (row->frame == 0)
        fprintf(f,
                "%5s %9s | %-31s | %-15s | %-15s | %s\n%5s %9s | %7s %7s %7s %7s | %7s %7s | %7s "
                "%7s |\n",
                "", "", "geometric error, px", "silhouette, px", "inside, outside",
                "colour PSNR, dB", "frame", "seconds", "rms", "median", "99.9 %", "maximum", "limb",
                "ridges", "missing", "extra");
    fprintf(f, "%5d %9.3f | %7.4f %7.4f %7.4f %7.3f | %7.3f %7.3f | %7zu %7zu | %.2f\n", row->frame,
            row->time_s, r->geometric_px.rms, r->geometric_px.median, r->geometric_px.rank_999,
            r->geometric_px.max, r->limb_px.mean, r->ridge_px.mean, r->missing_inside,
            r->extra_outside, r->psnr_db);
}

static const struct {
    const char *name;
    size_t offset; // of a double in compare_row
} places[] = {
    {"time_s", offsetof(compare_row, time_s)},
    {"lat", offsetof(compare_row, camera.lat_deg)},
    {"lon", offsetof(compare_row, camera.lon_deg)},
    {"alt", offsetof(compare_row, camera.alt_m)},
    {"heading", offsetof(compare_row, camera.heading_deg)},
    {"pitch", offsetof(compare_row, camera.pitch_deg)},
    {"roll", offsetof(compare_row, camera.roll_deg)},
    {"fov", offsetof(compare_row, camera.fov_deg)},
    {"easting", offsetof(compare_row, easting)},
    {"northing", offsetof(compare_row, northing)},
    {"zoom_low", offsetof(compare_row, zoom_low)},
    {"zoom_high", offsetof(compare_row, zoom_high)},
    {"psnr_db", offsetof(compare_row, result.psnr_db)},
    {"mse", offsetof(compare_row, result.mse)},
};

enum { PLACES = sizeof places / sizeof places[0] };

static double place_of(const compare_row *row, int i)
{
    return *(const double *)((const char *)row + places[i].offset);
}

void compare_report_csv_titles(FILE *f)
{
    for (int i = 0; i < PLACES; i++) fprintf(f, ",%s", places[i].name);
    for (int i = 0; i < COUNTS; i++) fprintf(f, ",%s", counts[i].name);
    for (int i = 0; i < MEASURES; i++) {
        fprintf(f, ",%s_count,%s_x,%s_y", measures[i].name, measures[i].name, measures[i].name);
        for (int k = 0; k < NUMBERS; k++) fprintf(f, ",%s_%s", measures[i].name, number_names[k]);
    }
}

void compare_report_csv_number(FILE *f, double value)
{
    fputc(',', f);
    if (!isnan(value)) fprintf(f, "%.12g", value);
}

void compare_report_csv_values(FILE *f, const compare_row *row)
{
    for (int i = 0; i < PLACES; i++) compare_report_csv_number(f, place_of(row, i));
    for (int i = 0; i < COUNTS; i++) fprintf(f, ",%zu", count_of(&row->result, i));
    for (int i = 0; i < MEASURES; i++) {
        const compare_stat *s = stat_of(&row->result, i);
        double numbers[NUMBERS];
        fprintf(f, ",%zu,%d,%d", s->count, s->x, s->y);
        numbers_of(s, numbers);
        for (int k = 0; k < NUMBERS; k++) compare_report_csv_number(f, numbers[k]);
    }
}

static status write_error(const char *path)
{
    log_error("%s: cannot write: %s", path, strerror(errno));
    return ERR_IO;
}

status compare_report_finish(FILE *f, const char *path)
{
    int failed = ferror(f);
    status s = OK;
    if (fclose(f) != 0 || failed) s = write_error(path);
    if (!s) s = output_commit(path);
    if (s) output_discard(path);
    return s;
}

status compare_report_begin(const char *path, FILE **out)
{
    char part[OUTPUT_PATH_SIZE];
    status s = output_part(path, part);
    if (s) return s;
    *out = fopen(part, "w");
    return *out ? OK : write_error(path);
}

status compare_report_csv(const char *path, const compare_row *rows, int count)
{
    FILE *f;
    status s = compare_report_begin(path, &f);
    if (s) return s;
    fputs("frame", f);
    compare_report_csv_titles(f);
    for (int i = 0; i < count; i++) {
        fprintf(f, "\n%d", rows[i].frame);
        compare_report_csv_values(f, &rows[i]);
    }
    fputc('\n', f);
    return compare_report_finish(f, path);
}

void compare_report_json_number(cJSON *object, const char *name, double value)
{
    if (isfinite(value)) cJSON_AddNumberToObject(object, name, value);
    else cJSON_AddNullToObject(object, name);
}

void compare_report_json_stat(cJSON *object, const char *name, const compare_stat *s)
{
    cJSON *part = cJSON_AddObjectToObject(object, name);
    double numbers[NUMBERS];
    compare_report_json_number(part, "count", (double)s->count);
    compare_report_json_number(part, "x", s->x);
    compare_report_json_number(part, "y", s->y);
    numbers_of(s, numbers);
    for (int k = 0; k < NUMBERS; k++) compare_report_json_number(part, number_names[k], numbers[k]);
}

void compare_report_json_members(cJSON *object, const compare_row *row)
{
    for (int i = 0; i < PLACES; i++)
        compare_report_json_number(object, places[i].name, place_of(row, i));
    for (int i = 0; i < COUNTS; i++)
        compare_report_json_number(object, counts[i].name, (double)count_of(&row->result, i));
    for (int i = 0; i < MEASURES; i++)
        compare_report_json_stat(object, measures[i].name, stat_of(&row->result, i));
}

static cJSON *json_row(const compare_row *row)
{
    cJSON *object = cJSON_CreateObject();
    cJSON_AddNumberToObject(object, "frame", row->frame);
    compare_report_json_members(object, row);
    return object;
}

status compare_report_json_write(const char *path, const cJSON *root)
{
    FILE *f;
    char *text = cJSON_Print(root);
    if (!text) {
        log_error("%s: out of memory", path);
        return ERR_MEMORY;
    }
    status s = compare_report_begin(path, &f);
    if (!s) {
        fprintf(f, "%s\n", text);
        s = compare_report_finish(f, path);
    }
    cJSON_free(text);
    return s;
}

status compare_report_json(const char *path, const compare_head *head, const compare_row *rows,
                           int count)
{
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "a", head->a);
    cJSON_AddStringToObject(root, "b", head->b);
    cJSON_AddStringToObject(root, "planet", head->planet);
    cJSON_AddNumberToObject(root, "width", head->width);
    cJSON_AddNumberToObject(root, "height", head->height);
    cJSON_AddBoolToObject(root, "bicubic", head->bicubic);
    cJSON_AddStringToObject(root, "psnr", FORMULA);
    cJSON_AddStringToObject(root, "colour", head->color_note);
    cJSON *frames = cJSON_AddArrayToObject(root, "frames");
    for (int i = 0; i < count; i++) cJSON_AddItemToArray(frames, json_row(&rows[i]));
    status s = compare_report_json_write(path, root);
    cJSON_Delete(root);
    return s;
}
