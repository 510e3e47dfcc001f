//! Figures as PDF, for LaTeX.

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use svg2pdf::usvg::fontdb::Database;
use svg2pdf::usvg::{Options, Tree};
use svg2pdf::{ConversionOptions, PageOptions};

use crate::files::archive::ArchiveError;

/// The fonts of all figures, the same on every machine.
static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.load_font_data(dejavu::sans::bold().to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

/// Pixels of an SVG in an inch, for which a PDF has 72 points.
const PIXELS_PER_INCH: f32 = 96.0;

/// The files of the figure `svg`, an SVG and a PDF: their names, made of `stem`, and contents.
///
/// # Errors
///
/// [`ArchiveError::Write`] if `svg` is no drawing.
pub fn figure_files(stem: &str, svg: &str) -> Result<[(String, Vec<u8>); 2], ArchiveError> {
    let path = format!("{stem}.pdf");
    let pdf = pdf_of(svg).map_err(|problem| {
        let path = PathBuf::from(&path);
        ArchiveError::Write { path, source: std::io::Error::other(problem) }
    })?;
    Ok([(format!("{stem}.svg"), svg.as_bytes().to_vec()), (path, pdf)])
}

/// The figure `svg` as a PDF of one page of its size, in the colours of print. Text stays text. The same figure gives the
/// same bytes.
///
/// # Errors
///
/// A message if `svg` is no drawing.
fn pdf_of(svg: &str) -> Result<Vec<u8>, String> {
    let options = Options { fontdb: Arc::clone(&FONTS), ..Options::default() };
    let tree = Tree::from_str(&without_themes(svg), &options).map_err(|error| error.to_string())?;
    svg2pdf::to_pdf(&tree, ConversionOptions::default(), PageOptions { dpi: PIXELS_PER_INCH })
        .map_err(|error| error.to_string())
}

/// `svg` without the style that follows the theme of a page, which the converter understands only in part. The attributes
/// have the colours of print.
fn without_themes(svg: &str) -> String {
    match (svg.split_once("<style>"), svg.split_once("</style>")) {
        (Some((before, _)), Some((_, after))) => format!("{before}{after}"),
        _ => svg.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn themes_of_pages_are_left_out() {
        let panel = "<rect class=\"f-paper\" width=\"9\" height=\"9\" fill=\"#ffffff\"/></svg>";
        let start = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\">";
        let themed = format!("{start}<style>.f-paper{{fill:var(--paper)}}</style>{panel}");
        assert_eq!(pdf_of(&themed).unwrap(), pdf_of(&format!("{start}{panel}")).unwrap());
    }

    #[test]
    fn a_figure_becomes_a_page_with_its_text() {
        let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="96" height="48"><text x="5" y="20" font-family="sans-serif"
            font-size="12" fill="black">F-rate</text><path d="M0 0h10" stroke="black"/></svg>"#;
        let pdf = pdf_of(svg).unwrap();
        assert!(pdf.starts_with(b"%PDF-"));
        let text = String::from_utf8_lossy(&pdf);
        assert!(text.contains("DejaVuSans"), "the font is embedded");
        // 72 points an inch, 96 pixels an inch.
        assert!(text.contains("/MediaBox [0 0 72 36]"), "{text}");
        assert_eq!(pdf, pdf_of(svg).unwrap());
        assert!(figure_files("rates", "<svg <").is_err());
        let [(svg_name, _), (pdf_name, _)] = figure_files("rates", svg).unwrap();
        assert_eq!([svg_name, pdf_name], ["rates.svg", "rates.pdf"]);
    }
}
