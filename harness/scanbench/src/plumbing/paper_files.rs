//! Tables and figures of a study as files for a page and for a paper.

use reports::files::archive::ArchiveError;
use reports::plots::pdf::figure_files;
use reports::run_folder::run_directory::RunDirectory;
use reports::tables::formats::format::Format as _;
use reports::tables::formats::latex::Latex;
use reports::tables::formats::markdown::Markdown;
use reports::tables::sheet::Tabular;

/// Writes `table` as Markdown and LaTeX, called `stem`.
pub fn write_table(directory: &RunDirectory, stem: &str, table: &impl Tabular) -> Result<(), ArchiveError> {
    directory.write_file(&format!("{stem}.md"), Markdown.text(table).as_bytes())?;
    directory.write_file(&format!("{stem}.tex"), Latex.text(table).as_bytes())
}

/// Writes the drawing `svg` as SVG and PDF, called `stem`.
pub fn write_figure(directory: &RunDirectory, stem: &str, svg: &str) -> Result<(), ArchiveError> {
    for (name, content) in figure_files(stem, svg)? {
        directory.write_file(&name, &content)?;
    }
    Ok(())
}
