// Which triangle drew which pixel: the identifiers of the mesh pass, read back and named.
#include <stdlib.h>

#include "base/log.h"
#include "render/view.h"

static int compare_numbers(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

// Sorts `numbers`; 0 does not count.
static uint64_t count_distinct(uint32_t *numbers, size_t n)
{
    uint64_t count = 0;
    qsort(numbers, n, sizeof *numbers, compare_numbers);
    for (size_t k = 0; k < n; k++)
        count += numbers[k] != 0 && (k == 0 || numbers[k] != numbers[k - 1]);
    return count;
}

// pairs: as mesh.frag writes them; numbers: of the triangle, 0 where there is none.
static void name_pixels(const perigee_view *v, const uint32_t *pairs, size_t n, uint32_t *numbers,
                        perigee_triangles *out)
{
    out->ground_pixels = 0;
    for (size_t k = 0; k < n; k++) {
        bool ground = pairs[2 * k] != 0;
        int level = -1, sector = -1;
        if (ground) v->geometry->mode->identify(v->geometry, pairs[2 * k] - 1, &level, &sector);
        numbers[k] = ground ? pairs[2 * k + 1] + 1 : 0;
        if (out->triangle) out->triangle[k] = numbers[k];
        if (out->level) out->level[k] = level;
        if (out->sector) out->sector[k] = sector;
        out->ground_pixels += ground;
    }
}

static status check_readable(const perigee_view *v, size_t pixels)
{
    if (!v->params.identify) {
        log_error("this view was not created to identify triangles");
        return ERR_ARGUMENT;
    }
    if (pixels) return OK;
    log_error("no frame has been rendered yet");
    return ERR_NOT_FOUND;
}

perigee_status perigee_view_read_triangles(perigee_view *v, perigee_triangles *out)
{
    const frame *f = &v->frame;
    size_t n = (size_t)f->light.width * (size_t)f->light.height;
    status s = check_readable(v, n);
    if (s) return (perigee_status)s;
    uint32_t *pairs = malloc(n * 3 * sizeof *pairs);
    if (!pairs) {
        log_error("no memory to read a frame of %d x %d", f->light.width, f->light.height);
        return ERR_MEMORY;
    }
    frame_read_identifiers(f, pairs);
    name_pixels(v, pairs, n, pairs + 2 * n, out);
    out->visible = count_distinct(pairs + 2 * n, n);
    free(pairs);
    return OK;
}
