//! SVG to PNG with the bundled font, so that no font has to be installed.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

use super::FigureError;

/// Family name of the bundled font.
pub(super) const FONT: &str = "Libertinus Serif";

/// Largest scale, so that a mistyped one does not need gigabytes of pixels.
const LARGEST_SCALE: f32 = 8.0;

pub(super) fn png(svg: &str, scale: f32) -> Result<Vec<u8>, FigureError> {
    if !(scale > 0.0 && scale <= LARGEST_SCALE) {
        return Err(FigureError::Size);
    }
    let mut options = Options::default();
    let fonts = options.fontdb_mut();
    // The regular face comes first; the others would only add megabytes.
    for face in typst_assets::fonts().take(1) {
        fonts.load_font_data(face.to_vec());
    }
    // Text in an unknown font is silently left out, so look before drawing.
    if !fonts.faces().any(|face| face.families.iter().any(|(name, _)| name == FONT)) {
        return Err(FigureError::Font);
    }
    let tree = Tree::from_str(svg, &options).map_err(|e| FigureError::Raster(e.to_string()))?;
    let size = tree.size().to_int_size().scale_by(scale);
    let size = size.ok_or(FigureError::Size)?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or(FigureError::Size)?;
    let zoom = Transform::from_scale(scale, scale);
    resvg::render(&tree, zoom, &mut pixels.as_mut());
    pixels.encode_png().map_err(|e| FigureError::Raster(e.to_string()))
}
