#include "app/help.h"

#include <stdio.h>
#include <string.h>

#include "app/option_table.h"

enum { HELP_COLUMN = 28, HELP_WIDTH = 98 };

static const char *const group_titles[GROUP_COUNT] = {
    [GROUP_IMPORT] = "Import",         [GROUP_COMPARE] = "Compare", [GROUP_CAMERA] = "Camera",
    [GROUP_FLIGHT] = "Flight",         [GROUP_PICTURE] = "Picture", [GROUP_OUTPUT] = "Output",
    [GROUP_DATA] = "Data and waiting", [GROUP_METHOD] = "Method",   [GROUP_GENERAL] = "General",
};

struct command_help {
    const char *usage, *summary, *examples;
};

static const struct command_help texts[COMMAND_COUNT] = {
    [COMMAND_VIEW] = {"perigee [view [PLANET] [OPTIONS]]",
                      "Explore the planet in a window. F1 lists its keys, among them M for the "
                      "next mode and V for "
                      "two modes side by\nside with their difference (X: how much of it).",
                      "  perigee view\n"
                      "  perigee view moon.planet --lat 26 --lon 3.6 --alt 50000 --pitch -30\n"
                      "  perigee view --camera 45.45,10.72,450,320,-3\n"
                      "  perigee view dem.tif\n"
                      "  perigee view --layer terrain-tiles --layer sentinel2-cloudless\n"},
    [COMMAND_RENDER] =
        {"perigee render [PLANET] [OPTIONS] -o FILE.png|FILE.exr",
         "Render one picture. An EXR holds linear R,G,B and, for each pixel, Z (metres along the "
         "view axis),\n"
         "height, lat, lon (with the residuals lat.lo and lon.lo beyond 32 bits) and level.",
         "  perigee render --lat 27.6 --lon 86.9 --alt 9000 --heading 20 --pitch -10 -o "
         "everest.png\n"
         "  perigee render --lat 45.45 --lon 10.72 --above-ground 2 --heading 320 --pitch 2 -o "
         "garda.exr\n"},
    [COMMAND_FLY] = {"perigee fly [PLANET] [OPTIONS] --path FILE -o PATTERN.png",
                     "Render a recorded flight to numbered pictures. The pattern holds one %d or "
                     "%0Nd for the number.",
                     "  perigee fly --path orbit-to-garda.json -o frames/%05d.png --fps 30\n"
                     "  perigee fly --path everest.json -o e/%04d.png --start 5 --end 8 "
                     "--contact-sheet e.png\n"},
    [COMMAND_IMPORT] =
        {"perigee import --height RASTER... [--color RASTER...] [OPTIONS] -o FILE.planet\n"
         "       perigee import --earth [--bathymetry] [-o FILE.planet]",
         "Make a planet file from rasters in any format and projection GDAL reads. Ctrl-C stops "
         "cleanly; what\n"
         "is done stays in FILE.planet.part and --resume goes on with it.",
         "  perigee import --height world.tif alps.tif --color blue.jpg -o my.planet\n"
         "  perigee import --height moon.tif --body moon --attribution 'NASA LROC/DLR GLD100' -o "
         "moon.planet\n"
         "  perigee import --earth --force\n"},
    [COMMAND_EXPORT] =
        {"perigee export [PLANET] -o FOLDER",
         "Write a planet as a folder of tiles with a TileJSON. Any web server can serve it, and\n"
         "another Perigee shows it by the URL of its planet.json.",
         "  perigee export alps.planet -o alps\n"
         "  perigee view http://localhost:8080/alps/planet.json\n"},
    [COMMAND_COMPARE] =
        {"perigee compare [PLANET] [--a SIDE] [--b SIDE] [OPTIONS]\n"
         "       perigee compare [PLANET] --modes all|A,B,... [--views FILE] [OPTIONS]",
         "Measure one way to render against another, pixel by pixel. The table goes to standard "
         "output. Where\n"
         "both show ground the geometric error is how far A's point lies from B's tangent plane, "
         "along the normal\n"
         "projected to the screen; at silhouettes it is how far the edges lie apart, in pixels. "
         "--modes puts\n"
         "several modes side by side, with what they cost; --equal gives all as many triangles, or "
         "one error.",
         "  perigee compare --lat 45.45 --lon 10.72 --above-ground 300 --pitch -5 --picture c.png\n"
         "  perigee compare moon.planet --camera 26,3.6,50000,0,-30 --size 640x480 -o errors\n"
         "  perigee compare --a a.exr --b b.exr --json c.json\n"
         "  perigee compare --path everest.json --frames 24 --csv c.csv --picture worst.png\n"
         "  perigee compare --modes all --views accuracy.json --size 320x240 --csv modes.csv\n"
         "  perigee compare --modes spherical,grid --equal error=0.5 --camera "
         "45.6,10.7,4000,0,-8\n"},
    [COMMAND_INFO] = {"perigee info [PLANET] [OPTIONS]", "Say what a planet file holds.",
                      "  perigee info earth.planet\n"
                      "  perigee info --json earth.planet\n"},
};

void help_program(FILE *f)
{
    fputs("Perigee flies from orbit to the ground over a whole planet.\n\n"
          "Usage: perigee [COMMAND [OPTIONS]]\n\n"
          "Commands (perigee COMMAND --help says more):\n",
          f);
    for (int i = 0; i < COMMAND_COUNT; i++) {
        const char *end = strchr(texts[i].summary, '.');
        fprintf(f, "  %-8s %.*s.\n", command_name((enum command)i), (int)(end - texts[i].summary),
                texts[i].summary);
    }
    fputs("\nAlone, perigee opens a window; without a display it renders its space-to-ground "
          "flight to\n"
          "frames/00000.png and so on, with frames/contact-sheet.png. Without PLANET it shows the "
          "default\n"
          "Earth, made at the first use from the atlas in Debian's package marble-qt-data.\n\n"
          "  --help     this text\n"
          "  --version  the version\n\n"
          "Environment:\n"
          "  PERIGEE_EARTH      planet file of the default Earth\n"
          "                     (default ${XDG_DATA_HOME:-~/.local/share}/perigee/earth.planet)\n"
          "  PERIGEE_DATA_DIR   folder with flights/ and atlas-relief-metres.csv, instead of the "
          "installed one\n"
          "  PERIGEE_EGL_DEVICE number of the EGL device to render on, from 0 (default: a card if "
          "any)\n"
          "  PERIGEE_COMPUTE    1 or 0: pixels by compute shaders or by fragments (default: 1 on "
          "cards)\n",
          f);
}

// Words from column HELP_COLUMN on, broken before HELP_WIDTH.
static void print_wrapped(FILE *f, int column, const char *text)
{
    if (column > HELP_COLUMN - 2) {
        fputc('\n', f);
        column = 0;
    }
    fprintf(f, "%*s", HELP_COLUMN - column, "");
    column = HELP_COLUMN;
    for (bool first = true; *text; first = false) {
        int length = (int)strcspn(text, " ");
        if (!first && column + 1 + length > HELP_WIDTH) {
            fprintf(f, "\n%*s", HELP_COLUMN, "");
            column = HELP_COLUMN;
        } else if (!first) {
            column += fprintf(f, " ");
        }
        column += fprintf(f, "%.*s", length, text);
        text += length + (text[length] == ' ');
    }
    fputc('\n', f);
}

static void print_option(FILE *f, const struct option_spec *spec)
{
    int column = fprintf(f, "  ");
    if (spec->letter) column += fprintf(f, "-%c, ", spec->letter);
    column += fprintf(f, "--%s", spec->name);
    if (spec->value_name) column += fprintf(f, " %s", spec->value_name);
    print_wrapped(f, column, spec->help);
}

void help_command(FILE *f, enum command command)
{
    const struct command_help *text = &texts[command];
    fprintf(f, "Usage: %s\n\n%s\n", text->usage, text->summary);
    for (int group = 0; group < GROUP_COUNT; group++) {
        bool titled = false;
        for (int i = 0; i < option_count; i++) {
            const struct option_spec *spec = &option_table[i];
            if ((int)spec->group != group || !(spec->commands & (1u << command))) continue;
            if (!titled) fprintf(f, "\n%s:\n", group_titles[group]);
            titled = true;
            print_option(f, spec);
        }
    }
    fprintf(f, "\nExamples:\n%s", text->examples);
}
