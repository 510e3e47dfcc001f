//! `scanbench data get`.

use std::path::PathBuf;

use reports::run_folder::command_line::shell_word;
use scans::dataset::DatasetError;
use scans::dataset::catalogue::CatalogueEntry;
use scans::dataset::root_template::UnsetVariable;
use simulator::catalogue::Catalogue;

use crate::cli::GetArgs;
use crate::plumbing::config::classes_of_project;
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::open_datasets::open_catalogue;
use crate::plumbing::remote::{GetPlan, get};
use crate::plumbing::standard_streams::{print_diagnostic, print_result};

/// Fetches a data set that its makers give without a login, or the file of a link from them, once its licence is accepted.
pub fn data_get(arguments: &GetArgs) -> Result<(), Failure> {
    // A catalogue may name classes of the user.
    classes_of_project()?;
    let catalogue = open_catalogue(arguments.catalogue.catalogue.as_deref())?;
    let id = arguments.dataset.as_str();
    let entry = recorded(id, &catalogue)?;
    let into = folder(arguments, entry)?;
    if entry.download.is_none() && arguments.link.is_none() {
        return Err(behind_a_login(id, entry, &into, &catalogue).into());
    }
    if !arguments.accept_licence {
        return Err(not_accepted(id, entry).into());
    }
    print_diagnostic(format_args!("{id}: {}", licence_of(entry)));
    let got = get(&GetPlan {
        id,
        download: entry.download.as_ref(),
        link: arguments.link.as_deref(),
        drives: &arguments.drives,
        into: &into,
        unpack_at_most_gb: arguments.unpack_at_most,
        is_dry_run: arguments.dry_run,
    })?;
    for archive in got.packed.iter().filter(|_| !arguments.dry_run) {
        print_diagnostic(format_args!("Unpack it: tar -xf {archive:?} -C {into:?}"));
    }
    if let Some(rest) = entry.download.as_ref().and_then(|it| it.rest.as_deref()) {
        print_diagnostic(rest);
    }
    print_result(format_args!("{}  {} files  {}", into.display(), got.n_files, got.size))
}

/// The entry of the data set `id`, which is no simulated one.
fn recorded<'a>(id: &str, catalogue: &'a Catalogue) -> Result<&'a CatalogueEntry, Failure> {
    if catalogue.simulated.contains_key(id) {
        return Err(Usage(format!(
            "{id:?} is simulated; there is nothing to fetch: scanbench run {}",
            shell_word(id)
        ))
        .into());
    }
    if let Some(members) = catalogue.groups.get(id) {
        return Err(Usage(format!("{id:?} is a group; fetch one of {}", members.join(", "))).into());
    }
    catalogue.recorded.get(id).ok_or_else(|| {
        let known: Vec<String> = catalogue.recorded.keys().cloned().collect();
        DatasetError::unknown_dataset(id, &known).into()
    })
}

/// Where it goes: where every verb looks for it, unless the user says otherwise.
fn folder(arguments: &GetArgs, entry: &CatalogueEntry) -> Result<PathBuf, Usage> {
    if let Some(into) = &arguments.into {
        return Ok(into.clone());
    }
    let expanded = entry.root.expand(|name| std::env::var_os(name));
    expanded.map_err(|UnsetVariable(name)| Usage(format!("set {name}, or say with --into where to fetch to")))
}

fn behind_a_login(id: &str, entry: &CatalogueEntry, into: &std::path::Path, catalogue: &Catalogue) -> Usage {
    let open: Vec<&str> = catalogue
        .recorded
        .iter()
        .filter(|(_, it)| it.download.is_some())
        .map(|(id, _)| id.as_str())
        .collect();
    let others =
        if open.is_empty() { String::new() } else { format!(". Without a login: {}", open.join(", ")) };
    let page = entry.url.as_deref().unwrap_or("their page");
    Usage(format!(
        "the makers of {id:?} ask for a login: get it from {page} and unpack it into {into:?}. If they give you a link: \
         scanbench data get {id} --link 'URL' --accept-licence{others}"
    ))
}

fn not_accepted(id: &str, entry: &CatalogueEntry) -> Usage {
    Usage(format!("{id:?} has a licence. {}. If you accept it, add --accept-licence", licence_of(entry)))
}

/// Name and page of the licence, and the page of the data.
fn licence_of(entry: &CatalogueEntry) -> String {
    let name = entry.licence.as_deref().unwrap_or("not named in the catalogue");
    let page = entry.licence_url.as_ref().map_or_else(String::new, |it| format!(", {it}"));
    let data = entry.url.as_ref().map_or_else(String::new, |it| format!("; data: {it}"));
    format!("Licence: {name}{page}{data}")
}
