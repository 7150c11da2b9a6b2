//! Corpora that are not on this machine: `ac-conform run s3://bucket/prefix`.
//!
//! A URL stands for what lies under it: traces, scenes, expectations and stage files, each found by the ending of its name as in a folder. They
//! are fetched into a cache and run from there; what the cache has, by name, size and entity tag, is not fetched again. If the store cannot be
//! reached, the copies of the last time are run, and a note says so.
//!
//! | URL | store | credentials from the environment |
//! |---|---|---|
//! | `s3://BUCKET/PREFIX` | Amazon S3 and what speaks its protocol | `AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`, `AWS_ENDPOINT`, … |
//! | `gs://BUCKET/PREFIX` | Google Cloud Storage | `GOOGLE_SERVICE_ACCOUNT`, … |
//! | `az://CONTAINER/PREFIX` | Azure Blob Storage | `AZURE_STORAGE_ACCOUNT_NAME`, `AZURE_STORAGE_ACCOUNT_KEY`, … |
//! | `http(s)://HOST/PREFIX` | WebDAV, or any server with the `index.json` of a corpus under the prefix | none |
//! | `file:///PATH` | a folder | none |
//!
//! The stores are behind the cargo feature `remote`, because their clients take longer to compile than all the rest.

#[cfg(feature = "remote")]
mod cache;
#[cfg(feature = "remote")]
mod failure;
#[cfg(feature = "remote")]
mod store;

use std::path::{Path, PathBuf};

/// Schemes of the stores.
const SCHEMES: [&str; 6] = ["s3", "gs", "az", "http", "https", "file"];

/// Where fetched files are kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Folder of the cache; made when it is needed.
    pub cache: PathBuf,
    /// Bytes that the cache may take. What was used longest ago goes first.
    pub limit: u64,
    /// Nothing is fetched: what the cache has is run.
    pub offline: bool,
}

/// Paths on this machine, with what was fetched in the place of URLs. The files are there as long as this is.
#[derive(Debug)]
pub struct Opened {
    /// Files and folders.
    pub paths: Vec<PathBuf>,
    /// What the user should know.
    pub notes: Vec<String>,
    #[cfg(feature = "remote")]
    _views: Vec<tempfile::TempDir>,
}

/// Why a corpus cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum RemoteError {
    /// This program cannot fetch.
    #[error(
        "{url}: this program was built without remote corpora; build it with `cargo build --release -p ac-conformance --features remote`, or name a folder"
    )]
    NotBuilt {
        /// The corpus.
        url: String,
    },
    /// The URL names no store.
    #[error(
        "{url}: {reason}; corpora are at s3://, gs://, az://, http://, https:// and file:// URLs"
    )]
    Url {
        /// The corpus.
        url: String,
        /// What is wrong with it.
        reason: String,
    },
    /// There is no such bucket or file.
    #[error("{url}: there is no such bucket, folder or file: {reason}")]
    NotFound {
        /// The corpus.
        url: String,
        /// What the store said.
        reason: String,
    },
    /// The store is there, and has nothing that can be run.
    #[error(
        "{url}: there is nothing to run: no file ends in .mcap or .scene.json; is the prefix right?"
    )]
    Empty {
        /// The corpus.
        url: String,
    },
    /// The store does not let us.
    #[error(
        "{url}: no permission; credentials come from the environment (AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, GOOGLE_SERVICE_ACCOUNT, AZURE_STORAGE_ACCOUNT_NAME and AZURE_STORAGE_ACCOUNT_KEY; AWS_SKIP_SIGNATURE=true for public buckets): {reason}"
    )]
    Permission {
        /// The corpus.
        url: String,
        /// What the store said.
        reason: String,
    },
    /// The store cannot be reached, and the cache does not have everything.
    #[error("{url}: cannot be reached, and {copies}: {reason}")]
    Unreachable {
        /// The corpus.
        url: String,
        /// What the cache has.
        copies: &'static str,
        /// What was tried.
        reason: String,
    },
    /// It does not fit into the cache.
    #[error(
        "{url}: its files take {need} bytes, the cache may take {limit}; allow more with --cache-limit, or name a part of it"
    )]
    TooLarge {
        /// The corpus.
        url: String,
        /// Bytes of its files.
        need: u64,
        /// Bytes of the cache.
        limit: u64,
    },
    /// A file is not what the list of files said.
    #[error(
        "{url}: {file} is not what the list of files says ({reason}): it was changed meanwhile; run again"
    )]
    Changed {
        /// The corpus.
        url: String,
        /// The file.
        file: String,
        /// What differs.
        reason: String,
    },
    /// A name that cannot be a file's.
    #[error("{url}: `{name}` cannot be the name of a file here")]
    Name {
        /// The corpus.
        url: String,
        /// The name.
        name: String,
    },
    /// The cache cannot be read or written.
    #[error("{}: {source}; another folder can be named with --cache", path.display())]
    Cache {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Something else.
    #[error("{url}: {reason}")]
    Store {
        /// The corpus.
        url: String,
        /// What the store said.
        reason: String,
    },
}

/// The URL that a path of a command line is; `None` for a path on this machine.
pub fn url_of(path: &Path) -> Option<&str> {
    let text = path.to_str()?;
    let (scheme, _) = text.split_once("://")?;
    // A folder may be called anything: only what looks like a scheme is one.
    let is_scheme = !scheme.is_empty() && scheme.bytes().all(|b| b.is_ascii_alphanumeric());
    is_scheme.then_some(text)
}

/// Bytes of a size like `500M` or `4G` (powers of 1024); a number alone is bytes.
///
/// # Errors
/// When the text is no size.
pub fn parse_size(text: &str) -> Result<u64, String> {
    let bad = || format!("`{text}` is no size like 500M or 4G");
    let unit = text.trim_end_matches(['B', 'b']).chars().last();
    let shift = match unit.map(|c| c.to_ascii_uppercase()) {
        Some('K') => 10,
        Some('M') => 20,
        Some('G') => 30,
        Some('T') => 40,
        _ => 0,
    };
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    if number.len() + 2 < text.len() || (shift == 0 && number.len() != text.len()) {
        return Err(bad());
    }
    let number: u64 = number.trim().parse().map_err(|_| bad())?;
    number.checked_mul(1 << shift).ok_or_else(bad)
}

/// The folder of the cache if none is named: `AC_CONFORM_CACHE`, else `ac-conform` in the user's folder of caches.
pub fn default_cache() -> PathBuf {
    let named = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    if let Some(folder) = named("AC_CONFORM_CACHE") {
        return folder.into();
    }
    let caches = named("XDG_CACHE_HOME")
        .or_else(|| named("LOCALAPPDATA"))
        .map(PathBuf::from)
        .or_else(|| Some(PathBuf::from(named("HOME")?).join(".cache")));
    caches.unwrap_or_else(std::env::temp_dir).join("ac-conform")
}

/// Fetches what URLs among the paths name; other paths stay as they are.
///
/// # Errors
/// When a corpus cannot be had.
pub fn open(paths: &[PathBuf], options: &Options) -> Result<Opened, RemoteError> {
    let mut opened = Opened {
        paths: Vec::with_capacity(paths.len()),
        notes: Vec::new(),
        #[cfg(feature = "remote")]
        _views: Vec::new(),
    };
    for path in paths {
        let Some(url) = url_of(path) else {
            opened.paths.push(path.clone());
            continue;
        };
        let scheme = url.split("://").next().unwrap_or_default();
        if !SCHEMES.contains(&scheme) {
            return Err(RemoteError::Url {
                url: url.into(),
                reason: format!("no store has the scheme `{scheme}`"),
            });
        }
        fetch(url, options, &mut opened)?;
    }
    Ok(opened)
}

#[cfg(feature = "remote")]
fn fetch(url: &str, options: &Options, opened: &mut Opened) -> Result<(), RemoteError> {
    let (view, note) = store::fetch(url, options)?;
    opened.paths.push(view.path().into());
    opened.notes.extend(note);
    opened._views.push(view);
    Ok(())
}

#[cfg(not(feature = "remote"))]
fn fetch(url: &str, _: &Options, _: &mut Opened) -> Result<(), RemoteError> {
    Err(RemoteError::NotBuilt { url: url.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn urls_are_told_from_paths() {
        for url in ["s3://b/p", "https://h/x.mcap", "ftp://h/x"] {
            assert_eq!(url_of(Path::new(url)), Some(url));
        }
        for path in ["traces", "./s3:/b", "a/b://c", "C:\\traces", "://x"] {
            assert_eq!(url_of(Path::new(path)), None, "{path}");
        }
    }

    #[test]
    fn sizes_are_read() {
        assert_eq!(parse_size("123"), Ok(123));
        assert_eq!(parse_size("2K"), Ok(2048));
        assert_eq!(parse_size("500M"), Ok(500 << 20));
        assert_eq!(parse_size("4GB"), Ok(4 << 30));
        assert_eq!(parse_size("1 T"), Ok(1 << 40));
        for bad in ["", "G", "4X", "-1", "4GiBB", "1.5G", "99999999999T"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }

    fn refused(url: &str) -> String {
        let options = Options {
            cache: PathBuf::from("/nonexistent/cache"),
            limit: 1,
            offline: true,
        };
        open(&[url.into()], &options).unwrap_err().to_string()
    }

    #[test]
    fn unknown_schemes_are_refused() {
        insta::assert_snapshot!(refused("ftp://host/corpus"), @"ftp://host/corpus: no store has the scheme `ftp`; corpora are at s3://, gs://, az://, http://, https:// and file:// URLs");
    }

    #[test]
    #[cfg(not(feature = "remote"))]
    fn a_program_without_stores_says_so() {
        insta::assert_snapshot!(refused("s3://bucket/corpus"), @"s3://bucket/corpus: this program was built without remote corpora; build it with `cargo build --release -p ac-conformance --features remote`, or name a folder");
    }
}
