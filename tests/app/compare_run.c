#include "app/compare_run.h"

#include <ftw.h>
#include <stdbool.h>
#include <sys/wait.h>
#include <unistd.h>

enum { FIELD_SIZE = 256 };

char out[TEXT_SIZE], err[TEXT_SIZE];
static char folder[] = "compare-XXXXXX";

void read_text(const char *path, char text[TEXT_SIZE])
{
    FILE *f = fopen(path, "rb");
    size_t n = f ? fread(text, 1, TEXT_SIZE - 1, f) : 0;
    text[n] = '\0';
    if (f) fclose(f);
}

void write_text(const char *path, const char *text)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs(text, f);
    assert_int_equal(fclose(f), 0);
}

int run(const char *line)
{
    char command[4096];
    snprintf(command, sizeof command, "\"%s\" %s >out.txt 2>err.txt", PERIGEE_PROGRAM, line);
    int state = system(command);
    read_text("out.txt", out);
    read_text("err.txt", err);
    return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
}

int count_lines(const char *text)
{
    int count = 0;
    for (; *text; text++) count += *text == '\n';
    return count;
}

void expect_good(const char *line)
{
    int state = run(line);
    if (state != 0) fail_msg("'%s': status %d: %s", line, state, err);
}

void expect_fault(const char *line, const char *words)
{
    int state = run(line);
    if (state != 1 || count_lines(err) != 1 || !strstr(err, words) || out[0])
        fail_msg("'%s': status %d, '%s' wanted: %s%s", line, state, words, err, out);
}

// One field without its quotes into `field`; the place of the next, NULL after the line's last.
static const char *take_field(const char *at, char field[FIELD_SIZE])
{
    size_t n = 0;
    bool quoted = *at == '"';
    if (quoted) at++;
    for (; *at && (quoted || (*at != ',' && *at != '\n')); at++) {
        if (quoted && *at == '"') {
            if (at[1] != '"') break;
            at++;
        }
        assert_true(n + 1 < FIELD_SIZE);
        field[n++] = *at;
    }
    if (quoted) at++;
    field[n] = '\0';
    return *at == ',' ? at + 1 : NULL;
}

const char *csv_text(const char *path, int row, const char *title)
{
    static char text[TEXT_SIZE], field[FIELD_SIZE];
    read_text(path, text);
    int column = 0;
    const char *at = text;
    for (; at; column++) {
        at = take_field(at, field);
        if (strcmp(field, title) == 0) break;
        if (!at) fail_msg("%s: no column %s", path, title);
    }
    at = text;
    for (int i = 0; i <= row; i++) {
        at = strchr(at, '\n');
        assert_non_null(at);
        at++;
    }
    for (int i = 0; i <= column; i++) {
        assert_non_null(at);
        at = take_field(at, field);
    }
    return field;
}

double csv_number(const char *path, int row, const char *title)
{
    const char *text = csv_text(path, row, title);
    return text[0] ? atof(text) : (double)NAN;
}

int run_begin(void **state)
{
    (void)state;
    if (!mkdtemp(folder) || chdir(folder) != 0) return -1;
    FILE *f = fopen("globe.asc", "w");
    assert_non_null(f);
    fputs("ncols 72\nnrows 36\nxllcorner -180\nyllcorner -90\ncellsize 5\n", f);
    for (int row = 0; row < 36; row++)
        for (int col = 0; col < 72; col++)
            fprintf(f, "%.1f ", 1000 * (1 + sin(row * M_PI / 18) * sin(col * M_PI / 12)));
    assert_int_equal(fclose(f), 0);
    write_text("globe.prj",
               "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],"
               "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]]");
    write_text(
        "path.json",
        "{\"keys\":[{\"time\":0,\"lat\":0,\"lon\":0,\"alt\":5e6,\"heading\":0,\"pitch\":-90},"
        "{\"time\":2,\"lat\":10,\"lon\":0,\"alt\":2e6,\"heading\":0,\"pitch\":-80}]}");
    expect_good("import --quiet --height globe.asc --name Hills --attribution Nobody "
                "-o hills.planet");
    return 0;
}

static int remove_one(const char *path, const struct stat *info, int kind, struct FTW *at)
{
    (void)info, (void)kind, (void)at;
    return remove(path);
}

int run_end(void **state)
{
    (void)state;
    return chdir("..") != 0 || nftw(folder, remove_one, 16, FTW_DEPTH | FTW_PHYS) != 0;
}
