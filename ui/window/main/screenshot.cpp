#include "ui/window/main/screenshot.h"

#include "geometry/base/text.h"
#include "ui/app/view/upright.h"
#include "ui/window/draw/mesh_picture.h"
#include "ui/window/gl/gl_context.h"
#include "ui/window/gl/picture_legend.h"

namespace kerf {

Expected<void> writeScreenshot(const ScreenshotOptions& options) {
  KERF_TRY(scene, loadScene(options.scene, options.section, options.unit));
  if (!scene.note.empty()) printText(stderr, "kerf-sim: note: {}\n", scene.note);
  const int width = options.width, height = options.height;
  Camera camera = options.camera;
  // The ground of a picture is fixed: this turns the mesh, not the camera.
  const auto found = options.up ? options.up : surelyUp(options.scene, scene.mesh);
  const Eigen::Matrix3d upright = found ? uprightFrame(*found) : Eigen::Matrix3d::Identity();
  if (!upright.isIdentity() && !options.up)
    printText(stderr, "kerf-sim: note: shown with {} up, the occlusal side of the scan; --up +z shows it as stored\n",
              nameOfAxis(*found));
  for (Vec3d& p : scene.mesh.vertices) p = upright * p;
  fitTo(camera, scene.mesh, width, height);
  if (options.look_at) camera.target = upright * *options.look_at;
  zoomBy(camera, options.zoom);

  KERF_TRY(context, OffscreenContext::create(!options.uses_gpu));
  if (options.tells) printText(stderr, "kerf-sim: drawing with {}\n", context->description);
  KERF_TRY(picture, MeshPicture::create());
  picture->setMesh(scene.mesh);

  PictureOptions look;
  look.ground_shadow = options.has_shadow;
  look.transparent = options.is_transparent;
  KERF_TRY(image, picture->picture(camera, width, height, look));
  const double mm_per_pixel = camera.mmPerPixel(height);
  if (options.has_grid) drawGrid(image, pictureGrid(camera, width, height, upright));
  if (options.has_scale_bar) drawScaleBar(image, scaleBarLength(mm_per_pixel, width), mm_per_pixel);
  return writePng(options.file, image);
}

}  // namespace kerf
