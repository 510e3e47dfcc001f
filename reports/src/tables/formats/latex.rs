//! LaTeX for a paper.

use std::fmt::Write as _;

use crate::tables::formats::format::Format;
use crate::tables::grid::{Alignment, Cell, Grid, Line, LineKind};
use crate::tables::notes::Notes;
use crate::tables::sheet::{Part, Tabular};

/// LaTeX floats; need the package `booktabs`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Latex;

impl<T: Tabular + ?Sized> Format<T> for Latex {
    fn file_name(&self, stem: &str) -> String {
        format!("{stem}.tex")
    }

    fn text(&self, subject: &T) -> String {
        let sheet = subject.printed();
        let mut text = "% Needs \\usepackage{booktabs}.\n".to_owned();
        for (part_idx, part) in sheet.parts.iter().enumerate() {
            let label = match part_idx {
                0 => sheet.label.clone(),
                _ => format!("{}-{}", sheet.label, part_idx + 1),
            };
            write_float(&mut text, part, &label, &sheet.notes);
        }
        text
    }
}

/// A table as a float, as in the papers.
fn write_float(text: &mut String, Part { title, grid }: &Part, label: &str, notes: &Notes) {
    let mut push = |line: &str| writeln!(text, "{line}").expect("a string takes all that is written");
    push("\\begin{table}");
    push("  \\centering");
    push(&format!("  \\caption{{{}}}", escaped(title.as_deref().unwrap_or(""))));
    push(&format!("  \\label{{tab:scanbench-{}}}", label_part(label)));
    push(&format!("  \\begin{{tabular}}{{{}}}", column_kinds(grid)));
    push("    \\toprule");
    for line in group_heads(grid).into_iter().flatten() {
        push(&format!("    {line}"));
    }
    let titles: Vec<_> = grid.columns.iter().map(|it| escaped(&it.title)).collect();
    push(&format!("    {} \\\\", titles.join(" & ")));
    push("    \\midrule");
    let fraction_widths = grid.fraction_widths();
    for (line_idx, line) in grid.lines.iter().enumerate() {
        if grid.begins_part(line_idx) {
            push("    \\midrule");
        }
        let cells = line.cells.iter().enumerate();
        let cells = cells.map(|(column_idx, cell)| match grid.columns[column_idx].alignment {
            Alignment::Left => left_text(line, cell, notes),
            Alignment::Decimal => decimal_text(line, cell, fraction_widths[column_idx], notes),
        });
        push(&format!("    {} \\\\", cells.collect::<Vec<_>>().join(" & ")));
    }
    push("    \\bottomrule");
    push("  \\end{tabular}");
    push("  \\par\\smallskip");
    push("  \\begin{minipage}{\\linewidth}\\footnotesize");
    for sentence in &notes.sentences {
        push(&format!("    {}\\par", escaped(sentence)));
    }
    push("  \\end{minipage}");
    push("\\end{table}");
}

fn column_kinds(grid: &Grid) -> String {
    let kinds = grid.columns.iter().map(|it| match it.alignment {
        Alignment::Left => 'l',
        Alignment::Decimal => 'r',
    });
    kinds.collect()
}

/// The names of the groups above their columns, and a rule beneath each, if there are groups.
fn group_heads(grid: &Grid) -> Option<[String; 2]> {
    let groups = grid.groups();
    groups.iter().any(|(name, _)| name.is_some()).then(|| heads_of(&groups))
}

fn heads_of(groups: &[(Option<&str>, usize)]) -> [String; 2] {
    let (mut names, mut rules) = (Vec::new(), Vec::new());
    let mut first_column = 1;
    for &(name, n_columns) in groups {
        let last_column = first_column + n_columns - 1;
        if let Some(name) = name {
            names.push(format!("\\multicolumn{{{n_columns}}}{{c}}{{{}}}", escaped(name)));
            rules.push(format!("\\cmidrule(lr){{{first_column}-{last_column}}}"));
        } else {
            names.extend(vec![String::new(); n_columns]);
        }
        first_column = last_column + 1;
    }
    [format!("{} \\\\", names.join(" & ")), rules.join(" ")]
}

fn left_text(line: &Line, cell: &Cell, notes: &Notes) -> String {
    let tag = Notes::tag(cell).map_or_else(String::new, |it| format!(" (\\emph{{{it}}})"));
    let text = format!("{}{}{tag}", escaped(&cell.text), escaped(&notes.sign(cell)));
    match line.kind {
        LineKind::Dataset | LineKind::Overall => text,
        LineKind::Detail => format!("\\quad {text}"),
        LineKind::Paper => format!("\\emph{{{text}}}"),
    }
}

/// A number, filled up with invisible digits where others in the column have more behind the decimal point.
fn decimal_text(line: &Line, cell: &Cell, fraction_width: usize, notes: &Notes) -> String {
    if cell.text.is_empty() {
        return String::new();
    }
    let text = escaped(&cell.text);
    if cell.is_interval {
        return format!("{{\\footnotesize {text}{}}}", escaped(&notes.sign(cell)));
    }
    let text = if line.kind == LineKind::Paper { format!("\\emph{{{text}}}") } else { text };
    let sign = match notes.sign(cell) {
        sign if sign.is_empty() => sign,
        // Hangs into the margin of the column, so that it does not push the number aside.
        sign => format!("\\rlap{{{}}}", escaped(&sign)),
    };
    let padding = match (cell.fraction().len(), fraction_width) {
        (own, all) if own == all => String::new(),
        (0, all) => format!("\\phantom{{.{}}}", "0".repeat(all - 1)),
        (own, all) => format!("\\phantom{{{}}}", "0".repeat(all - own)),
    };
    format!("{text}{sign}{padding}")
}

/// `text` as LaTeX prints it.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        match character {
            '\\' => escaped.push_str("\\textbackslash{}"),
            '~' => escaped.push_str("\\textasciitilde{}"),
            '^' => escaped.push_str("\\textasciicircum{}"),
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => escaped.extend(['\\', character]),
            '<' => escaped.push_str("$<$"),
            '>' => escaped.push_str("$>$"),
            '≥' => escaped.push_str("$\\geq$"),
            '≤' => escaped.push_str("$\\leq$"),
            '−' => escaped.push_str("$-$"),
            '–' => escaped.push_str("--"),
            '†' => escaped.push_str("$^\\dagger$"),
            '‡' => escaped.push_str("$^\\ddagger$"),
            '§' => escaped.push_str("\\S{}"),
            '¶' => escaped.push_str("\\P{}"),
            '¹' => escaped.push_str("$^1$"),
            '²' => escaped.push_str("$^2$"),
            '³' => escaped.push_str("$^3$"),
            control if control.is_control() => escaped.push(' '),
            other => escaped.push(other),
        }
    }
    escaped
}

/// `text` as a part of a label, which must not hold anything special.
fn label_part(text: &str) -> String {
    text.chars().map(|it| if it.is_ascii_alphanumeric() { it } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::sample;

    #[test]
    fn a_table_is_a_booktabs_float() {
        insta::assert_snapshot!(Latex.text(&sample::tables()[0]), @r"
        % Needs \usepackage{booktabs}.
        \begin{table}
          \centering
          \caption{Task objects. Rates in \%. Matched by a point-set IoU of at least 0.5.}
          \label{tab:scanbench-objects}
          \begin{tabular}{lrrrrrrrrrr}
            \toprule
             &  & \multicolumn{3}{c}{paper} & \multicolumn{3}{c}{kd-tree} & \multicolumn{3}{c}{pca} \\
            \cmidrule(lr){3-5} \cmidrule(lr){6-8} \cmidrule(lr){9-11}
            data set & NO & ND & F-rate & fps & ND & F-rate & fps & ND & F-rate & fps \\
            \midrule
            main\_road (\emph{simulated}) & 412 & 423 & 88.9 & 121\phantom{.0} & 480 & 76.2 & 8.04 & 415 & 76.9 & 46.0 \\
            \quad 95 \% interval &  &  & {\footnotesize 86.4--90.4} &  &  & {\footnotesize 73.7--77.7} &  &  & {\footnotesize 74.4--78.4} &  \\
            kitti\_tracking & 318 & --\rlap{$^1$} & --\rlap{$^1$}\phantom{.0} & 98.2 & --\rlap{$^1$} & --\rlap{$^1$}\phantom{.0} & 0.47 & --\rlap{$^1$} & --\rlap{$^1$}\phantom{.0} & 39.9 \\
            \quad recall, TP / NO &  &  & 91.2 &  &  & 85.2 &  &  & 64.2 &  \\
            kitti\_object & 61 & --\rlap{$^1$} & --\rlap{$^1$}\phantom{.0} & 104\phantom{.0} & --\rlap{$^1$} & --\rlap{$^1$}\phantom{.0} & 0.50 & --\rlap{$^1$} & --\rlap{$^1$}\phantom{.0} & 41.0 \\
            \quad recall, TP / NO &  &  & 90.2 &  &  & 100.0 &  &  & 65.6 &  \\
            \midrule
            overall (\emph{recorded}) & 379 & --\rlap{$^1$} & --\rlap{$^1$}\phantom{.0} & 101\phantom{.0} & --\rlap{$^1$} & --\rlap{$^1$}\phantom{.0} & 0.49 & --\rlap{$^1$} & --\rlap{$^1$}\phantom{.0} & 40.4 \\
            \quad recall, TP / NO &  &  & 91.0 &  &  & 87.6 &  &  & 64.4 &  \\
            \midrule
            \emph{published: Budapest \#1$^\dagger$} & \emph{669} &  & \emph{89}\phantom{.0} & \emph{29}\phantom{.0} &  & \emph{77}\phantom{.0} & \emph{0.38} &  &  &  \\
            \emph{published: Budapest \#2$^\dagger$} & \emph{429} &  & \emph{79}\phantom{.0} & \emph{25}\phantom{.0} &  & \emph{64}\phantom{.0} & \emph{0.22} &  &  &  \\
            \emph{published: KITTI} & \emph{496} &  & \emph{82}\phantom{.0} & \emph{29}\phantom{.0} &  & \emph{75}\phantom{.0} & \emph{0.46} &  &  &  \\
            \emph{published: overall$^\dagger$} & \emph{1594} &  & \emph{83}\phantom{.0} & \emph{28}\phantom{.0} &  & \emph{72}\phantom{.0} & \emph{0.35} &  &  &  \\
            \bottomrule
          \end{tabular}
          \par\smallskip
          \begin{minipage}{\linewidth}\footnotesize
            NO: annotations that count. ND: detections that count, TP + FO. F-rate: 2 TP / (NO + ND). fps: scans per second, detection only, on Example CPU @ 2 GHz.\par
            95 \% interval: cluster bootstrap, 10000 resamples of whole drives.\par
            overall: ratios of counts and times summed over the data sets, recorded and simulated ones apart.\par
            Numbers of data sets are measured here, and may be compared within a row. Published rows are printed in Börcs, Nagy, Benedek: Fast 3-D Urban Object Detection on Streaming Point Clouds, table 1; connected component analysis under kd-tree, hierarchical grid under paper. They are of other scans, annotations and machines: for orientation, and not to be compared with the numbers measured here.\par
            recorded: from a sensor.\par
            simulated: from a simulator, not recorded.\par
            $^\dagger$ Budapest recordings, not public; overall with those of KITTI.\par
            $^1$ undefined: not every class of object is annotated, so false objects cannot be counted.\par
          \end{minipage}
        \end{table}
        ");
    }

    #[test]
    fn what_means_something_to_latex_is_escaped() {
        assert_eq!(
            escaped("50 % & a_b #1 {$} ~ ^ \\ ≥ –\t¹"),
            "50 \\% \\& a\\_b \\#1 \\{\\$\\} \\textasciitilde{} \\textasciicircum{} \\textbackslash{} $\\geq$ -- $^1$"
        );
    }
}
