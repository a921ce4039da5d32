# Error against triangles by mode, from the CSV of perigee compare --modes, and flicker along flights.
#   gnuplot -e "views='defaults.csv triangles.csv error.csv'; out='modes.png'" compare_modes.gp
#   gnuplot -e "flights='a.csv b.csv'; out='flicker.png'" compare_modes.gp
# Debian: gnuplot-nox.
set datafile separator comma
set terminal pngcairo size 900,560 font "DejaVu Sans,10"
set output out
set grid
set logscale y
set key outside right top
modes = "spherical planar grid"
colors = "#1b6ca8 #c8553d #3a7d44"
titles = "rings squares grid"
rows(file, mode) = sprintf("< awk -v mode=%s 'NR == 1 || index($0, mode \",\") == 1' %s", mode, file)
if (exists("views")) {
    set logscale x
    set xlabel "triangles drawn"
    set ylabel "geometric error, 99.9 %, px (silhouettes left out)"
    set yrange [0.005:1000]
    set label 1 "each point a view" at graph 0.02, 0.04 tc rgb "#666666"
    plot for [m = 1:3] for [f = 1:words(views)] rows(word(views, f), word(modes, m)) \
        using "triangles_drawn":"geometric_px_p999" with points pt (f == 1 ? 7 : f == 2 ? 6 : 2) ps 0.9 \
        lc rgb word(colors, m) title word(titles, m)." ".word("defaults equal-triangles equal-error", f)
} else {
    set xlabel "frame of the flight"
    set ylabel "flicker, rms, px"
    set xtics 1
    set multiplot layout (words(flights) + 2) / 3, 3
    unset key
    do for [f = 1:words(flights)] {
        set title system("basename ".word(flights, f)." .csv") noenhanced
        if (f == words(flights)) { set key inside bottom right } else { unset key }
        plot for [m = 1:3] rows(word(flights, f), word(modes, m)) using "frame":"flicker_px_rms" \
            with linespoints pt 7 ps 0.6 lc rgb word(colors, m) title word(titles, m)
    }
    unset multiplot
}
