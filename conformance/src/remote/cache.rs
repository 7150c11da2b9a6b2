//! The cache of fetched files.
//!
//! ```text
//! DIR/objects/ab/cdef…   a file, named by the BLAKE3 of where it is from, its size and its entity tag
//! DIR/listings/…json     the last list of files of each corpus, for when it cannot be reached
//! DIR/views/…            the files of a running program under their own names
//! ```
//!
//! Files come to be under another name and are renamed when they are whole, so that two programs may share a cache and nothing half is ever
//! found. A view has hard links (copies where there are none), so that what is removed meanwhile stays readable to its end.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use serde::{Deserialize, Serialize};

use super::RemoteError;

/// Views that a program left behind are removed after this time.
const STALE: Duration = Duration::from_hours(48);

/// A file of a corpus.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Entry {
    /// Its name under the corpus, with slashes.
    pub name: String,
    /// Its size.
    pub size: u64,
    /// Changes when the content does: the entity tag, else the time of the last change.
    pub tag: String,
    /// BLAKE3 of the content, where the store says it.
    #[serde(default)]
    pub blake3: Option<String>,
}

/// The folder of the cache.
#[derive(Debug)]
pub(super) struct Cache {
    root: PathBuf,
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> RemoteError {
    let path = path.to_owned();
    move |source| RemoteError::Cache { path, source }
}

fn make(folder: &Path) -> Result<(), RemoteError> {
    fs::create_dir_all(folder).map_err(failed(folder))
}

impl Cache {
    pub(super) fn open(root: &Path) -> Result<Self, RemoteError> {
        for part in ["objects", "listings", "views"] {
            make(&root.join(part))?;
        }
        Ok(Self { root: root.into() })
    }

    /// Where the content of a file is, or would be.
    pub(super) fn object(&self, url: &str, entry: &Entry) -> PathBuf {
        let mut hasher = blake3::Hasher::new();
        for part in [url, &entry.name, &entry.tag] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part.as_bytes());
        }
        hasher.update(&entry.size.to_le_bytes());
        let hash = hasher.finalize().to_string();
        let (first, rest) = hash.split_at(2);
        self.root.join("objects").join(first).join(rest)
    }

    /// Whether the content of a file is there. It counts as used now.
    pub(super) fn has(&self, url: &str, entry: &Entry) -> bool {
        let path = self.object(url, entry);
        let there = fs::metadata(&path).is_ok_and(|data| data.len() == entry.size);
        if there && let Ok(file) = fs::File::options().append(true).open(&path) {
            // A cache that cannot be written is still read.
            let _ = file.set_modified(SystemTime::now());
        }
        there
    }

    /// A new file in the cache, to be [kept](Cache::keep) when it is whole.
    pub(super) fn new_file(&self) -> Result<tempfile::NamedTempFile, RemoteError> {
        let folder = self.root.join("objects");
        tempfile::Builder::new()
            .prefix(".part-")
            .tempfile_in(&folder)
            .map_err(failed(&folder))
    }

    /// Takes a whole file in.
    pub(super) fn keep(
        &self,
        file: tempfile::NamedTempFile,
        url: &str,
        entry: &Entry,
    ) -> Result<(), RemoteError> {
        let path = self.object(url, entry);
        if let Some(folder) = path.parent() {
            make(folder)?;
        }
        file.as_file().sync_all().map_err(failed(&path))?;
        let kept = file.persist(&path);
        kept.map(drop).map_err(|error| RemoteError::Cache {
            path,
            source: error.error,
        })
    }

    fn listing(&self, url: &str) -> PathBuf {
        let hash = blake3::hash(url.as_bytes()).to_string();
        self.root.join("listings").join(format!("{hash}.json"))
    }

    /// Remembers the files of a corpus.
    pub(super) fn save_listing(&self, url: &str, entries: &[Entry]) -> Result<(), RemoteError> {
        let path = self.listing(url);
        let text = serde_json::to_vec(entries).unwrap_or_default();
        let folder = self.root.join("listings");
        let mut file = tempfile::NamedTempFile::new_in(&folder).map_err(failed(&folder))?;
        std::io::Write::write_all(&mut file, &text).map_err(failed(&path))?;
        let kept = file.persist(&path);
        kept.map(drop).map_err(|error| RemoteError::Cache {
            path,
            source: error.error,
        })
    }

    /// The files of a corpus as they were the last time.
    pub(super) fn load_listing(&self, url: &str) -> Option<Vec<Entry>> {
        serde_json::from_slice(&fs::read(self.listing(url)).ok()?).ok()
    }

    /// A folder with the files of a corpus under their own names.
    pub(super) fn view(
        &self,
        url: &str,
        entries: &[Entry],
    ) -> Result<tempfile::TempDir, RemoteError> {
        let views = self.root.join("views");
        let view = tempfile::tempdir_in(&views).map_err(failed(&views))?;
        for entry in entries {
            let file = view.path().join(&entry.name);
            if let Some(folder) = file.parent() {
                make(folder)?;
            }
            let object = self.object(url, entry);
            fs::hard_link(&object, &file)
                .or_else(|_| fs::copy(&object, &file).map(drop))
                .map_err(failed(&file))?;
        }
        Ok(view)
    }

    /// Removes what was used longest ago until the files take no more than `limit` bytes. Those of `keep` stay.
    pub(super) fn evict(&self, limit: u64, keep: &BTreeSet<PathBuf>) {
        let mut files = Vec::new();
        let mut total = 0;
        for folder in children(&self.root.join("objects")) {
            for file in children(&folder) {
                let Ok(data) = fs::metadata(&file) else {
                    continue;
                };
                total += data.len();
                if !keep.contains(&file) {
                    let used = data.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                    files.push((used, file, data.len()));
                }
            }
        }
        files.sort();
        for (_, file, size) in files {
            if total <= limit {
                break;
            }
            if fs::remove_file(&file).is_ok() {
                total -= size;
            }
        }
        self.remove_leftovers();
    }

    /// Views and unfinished files of programs that were ended.
    fn remove_leftovers(&self) {
        let old = |path: &PathBuf| {
            let modified = fs::metadata(path).and_then(|data| data.modified());
            modified.is_ok_and(|at| at.elapsed().is_ok_and(|age| age > STALE))
        };
        for view in children(&self.root.join("views")).iter().filter(|p| old(p)) {
            let _ = fs::remove_dir_all(view);
        }
        let parts = children(&self.root.join("objects"));
        for part in parts.iter().filter(|path| path.is_file() && old(path)) {
            let _ = fs::remove_file(part);
        }
    }
}

fn children(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).collect()
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn entry(name: &str, text: &str) -> Entry {
        Entry {
            name: name.into(),
            size: text.len() as u64,
            tag: format!("tag of {text}"),
            blake3: None,
        }
    }

    fn put(cache: &Cache, url: &str, entry: &Entry, text: &str) {
        let mut file = cache.new_file().unwrap();
        file.write_all(text.as_bytes()).unwrap();
        cache.keep(file, url, entry).unwrap();
    }

    #[test]
    fn what_is_kept_is_found_and_shown() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::open(folder.path()).unwrap();
        let (a, b) = (entry("x/a.mcap", "aaa"), entry("b.mcap", "bb"));
        assert!(!cache.has("u", &a));
        put(&cache, "u", &a, "aaa");
        put(&cache, "u", &b, "bb");
        assert!(cache.has("u", &a));
        assert!(!cache.has("other", &a), "another corpus is another file");
        let view = cache.view("u", &[a.clone(), b]).unwrap();
        assert_eq!(fs::read(view.path().join("x/a.mcap")).unwrap(), b"aaa");
        // What is removed from the cache stays in a view.
        cache.evict(0, &BTreeSet::new());
        assert!(!cache.has("u", &a));
        assert_eq!(fs::read(view.path().join("x/a.mcap")).unwrap(), b"aaa");
    }

    #[test]
    fn what_was_used_longest_ago_goes_first() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::open(folder.path()).unwrap();
        let entries: Vec<Entry> = ["a", "b", "c"].map(|n| entry(n, "12345")).into();
        for (age, entry) in (1..).zip(&entries) {
            put(&cache, "u", entry, "12345");
            let file = fs::File::options()
                .append(true)
                .open(cache.object("u", entry))
                .unwrap();
            let at = SystemTime::now() - Duration::from_secs(1000 - age);
            file.set_modified(at).unwrap();
        }
        let keep = BTreeSet::from([cache.object("u", &entries[0])]);
        cache.evict(10, &keep);
        let there: Vec<bool> = entries.iter().map(|e| cache.has("u", e)).collect();
        assert_eq!(there, [true, false, true]);
    }

    #[test]
    fn lists_of_files_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::open(folder.path()).unwrap();
        assert_eq!(cache.load_listing("u"), None);
        let entries = vec![entry("a.mcap", "a")];
        cache.save_listing("u", &entries).unwrap();
        assert_eq!(cache.load_listing("u"), Some(entries));
    }
}
