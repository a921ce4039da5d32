# The whole way of real data: the 2-minute relief of the globe with insets up to 1 m of lidar, and real imagery, are imported,
# exported, served by nginx and flown from orbit to the ground; again from the cache without the server. Frames of both
# flights are the same, and those of the file are but for the rounding of heights. Minutes; a contact sheet is left at SHEET.
# usage: test_whole_way.sh ROOT PROGRAM DATA SHEET.png
set -euo pipefail
root=$1 perigee=$2 data=$3 sheet=$4
relief=$data/earth_elev_srtm30plus_2min_10800x5400_i16.tif
lidar=$data/lidar1m_slovenia_TM1_564_146_1000_f32.tif
imagery=$data/earth_bluemarble_8192x4096.jpg
for file in "$relief" "$lidar" "$imagery"; do
    [[ -e $file ]] || { echo "no $file"; exit 77; }
done
work=$(mktemp -d)
chmod 755 "$work"
cd "$work"
export HOME=$work PERIGEE_DATA_DIR=$root/data
unset XDG_CACHE_HOME SSL_CERT_FILE
source "$root/tests/app/serve.sh"

# The imagery says where it lies by a world file alone; its system is added here.
bands=
for band in 1 2 3; do
    bands+="<VRTRasterBand dataType=\"Byte\" band=\"$band\"><SimpleSource><SourceFilename>$imagery</SourceFilename>"
    bands+="<SourceBand>$band</SourceBand></SimpleSource></VRTRasterBand>"
done
cat >imagery.vrt <<VRT
<VRTDataset rasterXSize="8192" rasterYSize="4096"><SRS>EPSG:4326</SRS>
<GeoTransform>-180, 0.0439453125, 0, 90, 0, -0.0439453125</GeoTransform>$bands</VRTDataset>
VRT
insets=("$data"/srtm3_alps_oetztal_582x444_i16.tif "$data"/craterlake_bathymetry_30m_429x279_i16.tif "$lidar")
try "$perigee" import -q --height "$relief" "${insets[@]}" --color imagery.vrt "$data"/craterlake_imagery_30m_429x279_rgba.tif \
    --attribution 'SRTM30+, SRTM, USGS, Slovenian lidar; NASA Blue Marble' -o whole.planet
"$perigee" info whole.planet
try "$perigee" export -q whole.planet -o www/whole
echo "$(du -sm whole.planet | cut -f1) MB as a planet, $(du -sm www/whole | cut -f1) MB in $(find www -type f | wc -l) files"

cat >down.json <<'JSON'
{"name": "From orbit to 1 m of lidar", "fov": 60, "time": "2026-06-21T08:00Z", "keys": [
    {"time": 0, "lat": 30, "lon": 15.8, "alt": 12000000, "heading": 0, "pitch": -90, "fov": 45},
    {"time": 3, "lat": 44.6, "lon": 15.84, "alt": 500000, "heading": 0, "pitch": -60},
    {"time": 5, "lat": 46.1, "lon": 15.84, "alt": 40000, "heading": 0, "pitch": -35},
    {"time": 8, "lat": 46.42, "lon": 15.841, "aboveGround": 3000, "heading": 0, "pitch": -30},
    {"time": 11, "lat": 46.446, "lon": 15.841, "aboveGround": 500, "heading": 10, "pitch": -25},
    {"time": 15, "lat": 46.4525, "lon": 15.841, "aboveGround": 60, "heading": 40, "pitch": -12}]}
JSON
cat >lake.json <<'JSON'
{"name": "Crater Lake", "fov": 60, "time": "2026-06-21T18:00Z", "keys": [
    {"time": 0, "lat": 42.6, "lon": -122.11, "alt": 30000, "heading": 0, "pitch": -40},
    {"time": 3, "lat": 42.86, "lon": -122.11, "alt": 4500, "heading": 0, "pitch": -20}]}
JSON

fly() {
    local source=$1 into=$2
    mkdir -p "$into"
    for flight in down lake; do
        try "$perigee" fly "$source" --path $flight.json --fps 1 --size 320x240 -o "$into/$flight-%02d.png"
    done
}
configure_nginx
start_nginx
url=http://127.0.0.1:$port/whole/planet.json
fly "$url" served
bad=$(grep -cv ' 200 ' access.log || true)
echo "$(wc -l <access.log) requests, $bad for what is not there"
((bad == 0)) || fail "$bad requests for what is not there"
stop_nginx
fly "$url" cached
for frame in served/*.png; do cmp "$frame" "cached/${frame##*/}" || fail "the cache shows another flight"; done

ground=(--lat 46.4525 --lon 15.841 --alt 520 --heading 40 --pitch -25 --size 320x240)
try "$perigee" render "$url" "${ground[@]}" -o served.exr
try "$perigee" render whole.planet "${ground[@]}" -o file.exr
same served.exr file.exr 0.01
python3 "$root/tests/app/contact_sheet.py" "$sheet" 5 served/*.png
echo "looked at: $sheet"
