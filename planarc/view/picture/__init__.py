"""Still and moving pictures of a mechanism, from the same scene as the page.

    module      takes                    gives
    ---------   ----------------------   ------------------------------------------
    motion      Scene, times             Motion: the scene at the instants of frames
    camera      box, size                where a point of the world lies on the picture
    svg         Motion                   SVG text, still or moving
    raster      Motion                   images (Pillow)
    movie       images                   .gif (Pillow), .mp4 (imageio-ffmpeg), .png

`make.write_picture` calls them in a row; `view.marks` knows what an item looks like. `curves`
draws variables over time (matplotlib).
"""
