#include "app/compare_modes_report.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static void print_titles(FILE *f, const compare_modes_head *head)
{
    fprintf(f, "judged by %s; %s, %d x %d px; %s\n", head->judge, head->planet, head->width,
            head->height,
            head->repeats ? "GPU time: median of a turning camera's frames, first mode = 1"
                          : "GPU time not measured");
    if (head->flight)
        fprintf(f, "flicker: change in %.4g s of flight beyond the judge's own\n", head->step_s);
    if (head->equal != EQUAL_NOTHING)
        fprintf(f, "sizes chosen for equal %s, within %g %%; * not reached\n",
                head->equal == EQUAL_ERROR ? "99.9 % error" : "triangles drawn",
                100 * COMPARE_EQUAL_TOLERANCE);
    fprintf(f, "%-10s %6s | %-31s | %-15s | %-13s | %-25s | %8s %8s %6s%s\n", "", "",
            "geometric error, px", "edges apart, px", "inside, out", "triangles", "uploaded", "GPU",
            "GPU", head->flight ? " | flicker, px" : "");
    fprintf(f, "%-10s %6s | %7s %7s %7s %7s | %7s %7s | %6s %6s | %9s %9s %5s | %8s %8s %6s%s\n",
            "mode", "size", "rms", "median", "99.9 %", "maximum", "limb", "ridges", "missing",
            "extra", "drawn", "of all", "draws", "KiB", "MiB", "time",
            head->flight ? " |    rms  99.9 %" : "");
}

static void print_row(FILE *f, const compare_modes_head *head, const compare_mode_row *m)
{
    const compare_result *r = &m->row.result;
    char size[16], time[16] = "-";
    snprintf(size, sizeof size, "%.3g%s", m->size.size, m->size.met ? "" : "*");
    if (!isnan(m->gpu_time)) snprintf(time, sizeof time, "%.2f", m->gpu_time);
    fprintf(f,
            "%-10s %6s | %7.4f %7.4f %7.4f %7.3f | %7.3f %7.3f | %6zu %6zu | %9llu %9llu %5llu | "
            "%8.0f %8.1f %6s",
            m->mode, size, r->geometric_px.rms, r->geometric_px.median, r->geometric_px.rank_999,
            r->geometric_px.max, r->limb_px.mean, r->ridge_px.mean, r->missing_inside,
            r->extra_outside, (unsigned long long)m->triangles_drawn,
            (unsigned long long)m->triangles_total, (unsigned long long)m->draws,
            (head->flight ? m->bytes_step : (double)m->bytes_filled) / 1024,
            (double)m->gpu_bytes / 0x1p20, time);
    if (head->flight)
        fprintf(f, " | %6.4f %7.4f", m->flicker.moved_px.rms, m->flicker.moved_px.rank_999);
    fprintf(f, "\n");
    if (m->size.options[0]) fprintf(f, "%10s %6s   %s\n", "", "", m->size.options);
}

void compare_modes_report_lines(FILE *f, const compare_modes_head *head,
                                const compare_mode_row *rows, bool first)
{
    if (first) print_titles(f, head);
    if (rows->view[0] && head->flight) fprintf(f, "%s, %.3f s:\n", rows->view, rows->row.time_s);
    else if (rows->view[0]) fprintf(f, "%s:\n", rows->view);
    for (int k = 0; k < head->mode_count; k++) print_row(f, head, &rows[k]);
    fflush(f);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Median of the numbers that are none of them NaN; NaN of none.
static double median(double *values, int count)
{
    int known = 0;
    for (int i = 0; i < count; i++)
        if (!isnan(values[i])) values[known++] = values[i];
    if (!known) return NAN;
    qsort(values, (size_t)known, sizeof *values, ascending);
    return 0.5 * (values[known / 2] + values[(known - 1) / 2]);
}

static void print_mode(FILE *f, const compare_modes_head *head, const compare_mode_row *rows,
                       int cameras, int mode)
{
    double *values = NEW_ARRAY(double, 4 * (size_t)cameras);
    double *errors = values, *triangles = errors + cameras, *times = triangles + cameras,
           *moved = times + cameras, worst = NAN;
    size_t missing = 0, extra = 0;
    int at = 0, met = 0;
    for (int i = 0; i < cameras; i++) {
        const compare_mode_row *m = &rows[i * head->mode_count + mode];
        errors[i] = m->row.result.geometric_px.rank_999;
        if (!(errors[i] <= worst) && !isnan(errors[i])) worst = errors[i], at = i;
        triangles[i] = (double)m->triangles_drawn;
        times[i] = m->gpu_time;
        moved[i] = m->flicker.moved_px.rms;
        missing += m->row.result.missing_inside;
        extra += m->row.result.extra_outside;
        met += m->size.met;
    }
    fprintf(f, "%-10s %8.4f %8.4f %9zu %9zu %11.0f", head->modes[mode], median(errors, cameras),
            worst, missing, extra, median(triangles, cameras));
    if (head->repeats) fprintf(f, " %9.2f", median(times, cameras));
    if (head->flight) fprintf(f, " %8.4f", median(moved, cameras));
    if (head->equal != EQUAL_NOTHING) fprintf(f, " %4d of %d", met, cameras);
    fprintf(f, "  %s\n", rows[at * head->mode_count + mode].view);
    free(values);
}

void compare_modes_report_summary(FILE *f, const compare_modes_head *head,
                                  const compare_mode_row *rows, int count)
{
    int cameras = count / head->mode_count;
    fprintf(f, "\n%d %s; medians of them, the largest 99.9 %% and where, sums of pixels\n", cameras,
            head->flight ? "frames" : "views");
    fprintf(f, "%-10s %8s %8s %9s %9s %11s%s%s%s\n", "mode", "99.9 %", "largest", "missing",
            "extra", "triangles", head->repeats ? "  GPU time" : "",
            head->flight ? "  flicker" : "", head->equal != EQUAL_NOTHING ? "  reached" : "");
    for (int k = 0; k < head->mode_count; k++) print_mode(f, head, rows, cameras, k);
}

// A text in quotes, those in it doubled.
static void csv_text(FILE *f, const char *text)
{
    fputs(",\"", f);
    for (; *text; text++) {
        if (*text == '"') fputc('"', f);
        fputc(*text, f);
    }
    fputc('"', f);
}

static void csv_titles(FILE *f)
{
    fputs("mode,view,frame,size,reached,goal,options,triangles,triangles_drawn,draws,bytes_filled,"
          "bytes_step,gpu_bytes,gpu_time,flicker_px_rms,flicker_px_p999,flicker_px_max,"
          "flicker_color_rms,flicker_color_p999,flicker_color_max",
          f);
    compare_report_csv_titles(f);
    fputc('\n', f);
}

static void csv_row(FILE *f, const compare_mode_row *m)
{
    const compare_stat *moved = &m->flicker.moved_px, *color = &m->flicker.color;
    const double flicker[] = {moved->rms, moved->rank_999, moved->max,
                              color->rms, color->rank_999, color->max};
    fprintf(f, "%s", m->mode);
    csv_text(f, m->view);
    fprintf(f, ",%d,%.9g,%d", m->row.frame, m->size.size, m->size.met);
    compare_report_csv_number(f, m->goal);
    csv_text(f, m->size.options);
    fprintf(f, ",%llu,%llu,%llu,%llu", (unsigned long long)m->triangles_total,
            (unsigned long long)m->triangles_drawn, (unsigned long long)m->draws,
            (unsigned long long)m->bytes_filled);
    compare_report_csv_number(f, m->bytes_step);
    fprintf(f, ",%zu", m->gpu_bytes);
    compare_report_csv_number(f, m->gpu_time);
    for (int i = 0; i < 6; i++) compare_report_csv_number(f, flicker[i]);
    compare_report_csv_values(f, &m->row);
    fputc('\n', f);
}

status compare_modes_report_csv(const char *path, const compare_mode_row *rows, int count)
{
    FILE *f;
    status s = compare_report_begin(path, &f);
    if (s) return s;
    csv_titles(f);
    for (int i = 0; i < count; i++) csv_row(f, &rows[i]);
    return compare_report_finish(f, path);
}

static cJSON *json_row(const compare_mode_row *m)
{
    cJSON *object = cJSON_CreateObject();
    cJSON_AddStringToObject(object, "mode", m->mode);
    cJSON_AddStringToObject(object, "view", m->view);
    cJSON_AddNumberToObject(object, "frame", m->row.frame);
    cJSON_AddNumberToObject(object, "size", m->size.size);
    cJSON_AddBoolToObject(object, "reached", m->size.met);
    compare_report_json_number(object, "goal", m->goal);
    cJSON_AddStringToObject(object, "options", m->size.options);
    compare_report_json_number(object, "triangles", (double)m->triangles_total);
    compare_report_json_number(object, "triangles_drawn", (double)m->triangles_drawn);
    compare_report_json_number(object, "draws", (double)m->draws);
    compare_report_json_number(object, "bytes_filled", (double)m->bytes_filled);
    compare_report_json_number(object, "bytes_step", m->bytes_step);
    compare_report_json_number(object, "gpu_bytes", (double)m->gpu_bytes);
    compare_report_json_number(object, "gpu_time", m->gpu_time);
    compare_report_json_stat(object, "flicker_px", &m->flicker.moved_px);
    compare_report_json_stat(object, "flicker_color", &m->flicker.color);
    compare_report_json_members(object, &m->row);
    return object;
}

status compare_modes_report_json(const char *path, const compare_modes_head *head,
                                 const compare_mode_row *rows, int count)
{
    static const char *const equal[] = {"nothing", "triangles", "error"};
    cJSON *root = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(root, "rows");
    cJSON_AddItemToObject(root, "modes", cJSON_CreateStringArray(head->modes, head->mode_count));
    cJSON_AddStringToObject(root, "judge", head->judge);
    cJSON_AddStringToObject(root, "planet", head->planet);
    cJSON_AddNumberToObject(root, "width", head->width);
    cJSON_AddNumberToObject(root, "height", head->height);
    cJSON_AddStringToObject(root, "equal", equal[head->equal]);
    cJSON_AddNumberToObject(root, "tolerance", COMPARE_EQUAL_TOLERANCE);
    cJSON_AddNumberToObject(root, "repeats", head->repeats);
    compare_report_json_number(root, "step_s", head->flight ? head->step_s : NAN);
    for (int i = 0; i < count; i++) cJSON_AddItemToArray(list, json_row(&rows[i]));
    status s = compare_report_json_write(path, root);
    cJSON_Delete(root);
    return s;
}
