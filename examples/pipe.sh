# Restyles a film between two ffmpegs and keeps its sound: sh pipe.sh in.mp4 out.mp4
ffmpeg -v error -i "$1" -f yuv4mpegpipe -pix_fmt yuv420p - |
    vidstyle render - - --style ink --format yuv4mpegpipe |
    ffmpeg -v error -i - -i "$1" -map 0:v -map '1:a?' -c:a copy "$2"
