#include "app/frame_pattern.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "app/output_file.h"
#include "base/log.h"

// Length of a "%d", "%5d" or "%05d" at p with its width of digits (0-9), or 0 when there is none.
static int number_at(const char *p, int *digits)
{
    const char *start = p++;
    *digits = 0;
    if (*p == '0') p++;
    if (isdigit((unsigned char)*p)) *digits = *p++ - '0';
    return *p == 'd' ? (int)(p + 1 - start) : 0;
}

static status refuse(const char *pattern, const char *why)
{
    log_error("-o %s: %s", pattern, why);
    return ERR_ARGUMENT;
}

status frame_pattern_check(const char *pattern)
{
    int numbers = 0, digits;
    const char *number = NULL;
    if (output_has_extension(pattern, ".mp4"))
        return refuse(
            pattern,
            "video is not offered; render frames and use, for example, ffmpeg -i frames/%05d.png");
    for (const char *p = pattern; *p; p++) {
        if (*p != '%') continue;
        int length = number_at(p, &digits);
        if (p[1] == '%') p++;
        else if (length == 0)
            return refuse(pattern, "only %d, %0Nd and %% may follow a percent sign");
        else {
            numbers++;
            number = p;
        }
    }
    if (numbers != 1)
        return refuse(pattern, "the pattern needs exactly one %d, such as frames/%05d.png");
    if (strchr(number, '/'))
        return refuse(pattern, "the number must be in the file's name, not in a folder's");
    if (!output_has_extension(pattern, ".png"))
        return refuse(pattern, "frames are written as .png");
    return OK;
}

status frame_pattern_path(const char *pattern, int frame, char *path, size_t size)
{
    size_t used = 0;
    for (const char *p = pattern; *p && used + 1 < size;) {
        int digits, length = *p == '%' ? number_at(p, &digits) : 0;
        if (length > 0) {
            int n = snprintf(path + used, size - used, "%0*d", digits, frame);
            used += (size_t)n;
            p += length;
        } else {
            path[used++] = *p;
            p += *p == '%' ? 2 : 1;
        }
    }
    if (used + 1 >= size) return refuse(pattern, "the path is too long");
    path[used] = '\0';
    return OK;
}
