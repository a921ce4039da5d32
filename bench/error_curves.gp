# Error against triangles and against time, a curve a view, from the CSV of bench_error --time, one run after the other:
#   for v in "air, Oetztal" "air, Korea, down"; do bench_error --time PLANET all "$v"; done >curves.csv
#   gnuplot -e "data='curves.csv'; out='error.png'" error_curves.gp
# The curve goes from the coarsest setting to the finest; the paper's and the default with bilinear heights stand beside it.
# Debian: gnuplot-nox.
set datafile separator comma
set terminal pngcairo size 1200,560 font "DejaVu Sans,10"
set output out
set grid
set logscale xy
set yrange [0.2:8]
set ytics (0.2, 0.3, 0.5, 0.9, 1.4, 2, 3, 5, 8)
count = int(system(sprintf("awk -F'\"' '$2 != \"\" && !seen[$2]++ {n++} END {print n + 0}' %s", data)))
name(i) = system(sprintf("awk -F'\"' '$2 != \"\" && !seen[$2]++ && ++n == %d {print $2}' %s", i, data))
rows(i, which) = sprintf("< awk -F'\"' '$2 == \"%s\" && ($1 ~ /^(paper|bilinear),/) == %d && $3 ~ /^,all,/ {print $1 $3}' %s", name(i), which, data)
colors = "#1b6ca8 #c8553d #3a7d44 #8a5a9e #b58900 #444444"
set multiplot layout 1, 2
set ylabel "geometric error, 99.9 %, px of 1280 x 960"
set xlabel "triangles drawn for each pixel of ground"
set xtics (0.05, 0.1, 0.2, 0.5, 1, 2)
set xrange [0.04:3]
set key inside top right
set label 1 "crosses: the paper's setting, and the default with bilinear heights" at graph 0.02, 0.03 tc rgb "#666666"
plot for [i = 1:count] rows(i, 0) using 10:6 with linespoints pt 7 ps 0.8 lc rgb word(colors, i) title name(i), \
    for [i = 1:count] rows(i, 1) using 10:6 with points pt 2 ps 1 lc rgb word(colors, i) notitle, \
    rows(1, 0) using 10:6:1 with labels font ",8" offset 0, 0.9 notitle
unset label 1
unset ylabel
unset key
set xlabel "time of a frame of a turning camera, the default = 1"
set xtics (0.5, 0.7, 1, 1.4, 2, 3, 4)
set xrange [0.5:4]
plot for [i = 1:count] rows(i, 0) using 13:6 with linespoints pt 7 ps 0.8 lc rgb word(colors, i), \
    for [i = 1:count] rows(i, 1) using 13:6 with points pt 2 ps 1 lc rgb word(colors, i), \
    rows(1, 0) using 13:6:1 with labels font ",8" offset 0, 0.9
unset multiplot
