//! The options of commands that read corpora from elsewhere.

use std::path::PathBuf;

use miette::IntoDiagnostic;

use crate::remote::{self, Opened, Options};

/// Options for `s3://`, `gs://`, `az://`, `http(s)://` and `file://` paths.
#[derive(clap::Args)]
#[command(next_help_heading = "Corpora at URLs")]
#[group(id = "remote")]
pub struct Args {
    /// Folder in which fetched files are kept. Default: AC_CONFORM_CACHE, else `ac-conform` in the user's folder of caches.
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Bytes that the folder may take; what was used longest ago goes first.
    #[arg(long, value_name = "SIZE", default_value = "4G", value_parser = remote::parse_size)]
    cache_limit: u64,
    /// Fetch nothing: run what the cache has of the last time.
    #[arg(long)]
    offline: bool,
}

impl Args {
    /// Fetches what URLs among the paths name. Notes go to standard error.
    ///
    /// # Errors
    /// When a corpus cannot be had.
    pub fn open(&self, paths: &[PathBuf]) -> miette::Result<Opened> {
        let options = Options {
            cache: self.cache.clone().unwrap_or_else(remote::default_cache),
            limit: self.cache_limit,
            offline: self.offline,
        };
        let opened = remote::open(paths, &options).into_diagnostic()?;
        for note in &opened.notes {
            eprintln!("note: {note}");
        }
        Ok(opened)
    }
}
