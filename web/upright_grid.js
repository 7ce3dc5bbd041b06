// A floor map may be turned in its map frame, and Leaflet lays images along the axes only.

// `grid` is {image, resolution, origin: {x, y, yaw}}. Returns the image that covers the box around it along the
// axes, with the size in pixels and the origin of that box; what is not the grid's is transparent.
export async function uprightGrid(grid) {
  const bitmap = await createImageBitmap(grid.image);
  const { width, height } = bitmap;
  const { x, y, yaw } = grid.origin;
  const cos = Math.cos(yaw);
  const sin = Math.sin(yaw);
  // The grid's corners, in cells from its origin, y up.
  const xs = [0, width * cos, -height * sin, width * cos - height * sin];
  const ys = [0, width * sin, height * cos, width * sin + height * cos];
  const left = Math.min(...xs);
  const bottom = Math.min(...ys);
  const canvas = new OffscreenCanvas(Math.ceil(Math.max(...xs) - left), Math.ceil(Math.max(...ys) - bottom));
  const context = canvas.getContext('2d');
  context.imageSmoothingEnabled = false;
  // Pixels count from the upper left corner, y down, in the image as on the canvas.
  context.setTransform(cos, -sin, sin, cos, -height * sin - left, canvas.height + bottom - height * cos);
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  return {
    image: await canvas.convertToBlob(), width: canvas.width, height: canvas.height, resolution: grid.resolution,
    origin: { x: x + left * grid.resolution, y: y + bottom * grid.resolution },
  };
}
