# Makes a comic page of a film: sh comic_page.sh in.mp4 page.png
vidstyle comic "$1" "$2" --panels 4 --style comic,ink --title "A short film" --seed 2
