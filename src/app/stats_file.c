#include "app/stats_file.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>

#include "base/log.h"

status stats_file_open(struct stats_file *f, const char *path)
{
    *f = (struct stats_file){.path = path};
    if (!path) return OK;
    f->file = fopen(path, "w");
    if (f->file) return OK;
    log_error("%s: cannot write: %s", path, strerror(errno));
    return ERR_IO;
}

static void print_work(struct stats_file *f, const perigee_stats *s)
{
    fprintf(f->file,
            "\"first_level\":%" PRIu32 ",\"last_level\":%" PRIu32 ",\"triangles_total\":%" PRIu64
            ",\"triangles_drawn\":%" PRIu64 ",\"vertices_placed\":%" PRIu64
            ",\"bytes_uploaded\":%" PRIu64 ",\"draws\":%" PRIu64 ",",
            s->first_level, s->last_level, s->triangles_total, s->triangles_drawn,
            s->total_vertices_placed - f->placed, s->total_bytes_uploaded - f->uploaded, s->draws);
    f->uploaded = s->total_bytes_uploaded;
    f->placed = s->total_vertices_placed;
}

// Stills are not timed by every path of the renderer: what was not measured is null.
static void print_time(FILE *file, const char *name, double ms)
{
    if (ms > 0) fprintf(file, ",\"%s\":%.3f", name, ms);
    else fprintf(file, ",\"%s\":null", name);
}

static void print_place(FILE *file, const struct session *session, const perigee_camera *camera)
{
    double easting, northing;
    perigee_camera c = session_geographic(session, camera);
    fprintf(file, "\"lat\":%.9f,\"lon\":%.9f,", c.lat_deg, c.lon_deg);
    if (session_map_coordinates(session, camera, &easting, &northing))
        fprintf(file, "\"easting\":%.3f,\"northing\":%.3f,", easting, northing);
    fprintf(file, "\"alt\":%.3f,\"heading\":%.6f,\"pitch\":%.6f,", c.alt_m, c.heading_deg,
            c.pitch_deg);
}

void stats_file_add(struct stats_file *f, const struct session *session, int frame, double time_s,
                    const perigee_camera *camera)
{
    if (!f->file) return;
    perigee_stats s;
    const perigee_view *view = session->view;
    perigee_view_get_stats(view, &s);
    fprintf(f->file, "{\"frame\":%d,\"time\":%.6f,", frame, time_s);
    print_place(f->file, session, camera);
    print_work(f, &s);
    fprintf(f->file,
            "\"missing\":%d,\"tiles_decoded\":%" PRIu64 ",\"tiles_synthesised\":%" PRIu64
            ",\"tiles_corrupt\":%" PRIu64 ",\"gpu_bytes\":%zu,\"gpu_bytes_targets\":%zu",
            perigee_view_missing(view, NULL, 0), s.tiles_decoded, s.tiles_synthesised,
            s.tiles_corrupt, s.gpu_bytes, s.gpu_bytes_targets);
    print_time(f->file, "cpu_ms", s.cpu_ms);
    print_time(f->file, "gpu_ms", s.gpu_ms);
    fputs("}\n", f->file);
}

status stats_file_close(struct stats_file *f)
{
    if (!f->file) return OK;
    int failed = ferror(f->file);
    if (fclose(f->file) != 0 || failed) {
        log_error("%s: cannot write: %s", f->path, strerror(errno));
        f->file = NULL;
        return ERR_IO;
    }
    f->file = NULL;
    return OK;
}
