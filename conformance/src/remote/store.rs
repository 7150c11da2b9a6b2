//! Lists and fetches the files of a corpus.

use std::{collections::BTreeSet, io::Write, path::PathBuf, sync::Arc, time::Duration};

use ac_golden_traces::corpus::{
    EXPECT_SUFFIXES, Index, SCENE_SUFFIX, STAGE_SUFFIXES, TRACE_SUFFIX,
};
use futures_util::{StreamExt, TryStreamExt};
use object_store::{
    ClientOptions, ObjectMeta, ObjectStore, ObjectStoreExt, ObjectStoreScheme, RetryConfig,
    aws::AmazonS3Builder, azure::MicrosoftAzureBuilder, gcp::GoogleCloudStorageBuilder,
    http::HttpBuilder, local::LocalFileSystem, path::Path,
};
use tempfile::TempDir;
use url::Url;

use super::{
    Options, RemoteError,
    cache::{Cache, Entry},
    failure::classify,
};

/// Files that are fetched at the same time.
const AT_ONCE: usize = 8;
/// Files that one corpus may have.
const MAX_FILES: usize = 1_000_000;
/// An `index.json` longer than this is refused.
const MAX_INDEX: u64 = 64 << 20;
/// How long connecting may take.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// How long a failing request is tried again.
const RETRY_TIMEOUT: Duration = Duration::from_secs(15);

/// A corpus in its store.
struct Corpus {
    url: String,
    store: Arc<dyn ObjectStore>,
    /// What lies under it is the corpus.
    prefix: Path,
    is_http: bool,
}

/// The files of a corpus under their own names, and what the user should know.
pub(super) fn fetch(
    url: &str,
    options: &Options,
) -> Result<(TempDir, Option<String>), RemoteError> {
    let cache = Cache::open(&options.cache)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| RemoteError::Store {
            url: url.into(),
            reason: error.to_string(),
        })?;
    let (entries, note) = runtime.block_on(bring(url, options, &cache))?;
    let view = cache.view(url, &entries)?;
    let keep: BTreeSet<PathBuf> = entries.iter().map(|e| cache.object(url, e)).collect();
    cache.evict(options.limit, &keep);
    Ok((view, note))
}

/// Brings the files of a corpus into the cache.
async fn bring(
    url: &str,
    options: &Options,
    cache: &Cache,
) -> Result<(Vec<Entry>, Option<String>), RemoteError> {
    if options.offline {
        return copies(url, cache, "--offline was given".into());
    }
    let corpus = Corpus::open(url)?;
    match corpus.bring(options, cache).await {
        Err(RemoteError::Unreachable { reason, .. }) => copies(url, cache, reason),
        other => Ok((other?, None)),
    }
}

/// The copies of the last time.
fn copies(
    url: &str,
    cache: &Cache,
    reason: String,
) -> Result<(Vec<Entry>, Option<String>), RemoteError> {
    let unreachable = |copies| RemoteError::Unreachable {
        url: url.into(),
        copies,
        reason: reason.clone(),
    };
    let entries = cache
        .load_listing(url)
        .ok_or_else(|| unreachable("the cache has no copy of it"))?;
    if !entries.iter().all(|entry| cache.has(url, entry)) {
        return Err(unreachable("the cache has only a part of it"));
    }
    let note = format!(
        "{url} cannot be reached: running the {} files that the cache has of the last time ({reason})",
        entries.len()
    );
    Ok((entries, Some(note)))
}

impl Corpus {
    fn open(text: &str) -> Result<Self, RemoteError> {
        let bad = |reason: String| RemoteError::Url {
            url: text.into(),
            reason,
        };
        let url = Url::parse(text).map_err(|error| bad(error.to_string()))?;
        let (scheme, prefix) =
            ObjectStoreScheme::parse(&url).map_err(|error| bad(error.to_string()))?;
        let is_http = scheme == ObjectStoreScheme::Http;
        let store = store_of(&url, &scheme).map_err(|error| classify(text, &error))?;
        Ok(Self {
            url: text.into(),
            store,
            prefix,
            is_http,
        })
    }

    /// Brings what the cache does not have.
    async fn bring(&self, options: &Options, cache: &Cache) -> Result<Vec<Entry>, RemoteError> {
        let entries = self.list().await?;
        let need = entries.iter().map(|entry| entry.size).sum();
        if need > options.limit {
            return Err(RemoteError::TooLarge {
                url: self.url.clone(),
                need,
                limit: options.limit,
            });
        }
        let wanted: Vec<&Entry> = entries
            .iter()
            .filter(|entry| !cache.has(&self.url, entry))
            .collect();
        futures_util::stream::iter(wanted)
            .map(|entry| self.download(entry, cache))
            .buffer_unordered(AT_ONCE)
            .try_collect::<()>()
            .await?;
        cache.save_listing(&self.url, &entries)?;
        Ok(entries)
    }

    /// The files that can be run, and what belongs to them.
    async fn list(&self) -> Result<Vec<Entry>, RemoteError> {
        let mut entries = if is_wanted(self.prefix.as_ref()) {
            let meta = self.store.head(&self.prefix).await;
            vec![self.entry(meta.map_err(|error| self.error(&error))?)?]
        } else {
            match self.list_prefix().await {
                Err(RemoteError::Unreachable {
                    url,
                    copies,
                    reason,
                }) => {
                    return Err(RemoteError::Unreachable {
                        url,
                        copies,
                        reason,
                    });
                }
                // Most web servers do not list; a corpus has an index.
                Err(error) if self.is_http => self.list_index().await.map_err(|_| error)?,
                other => other?,
            }
        };
        entries.sort_by(|a, b| a.name.cmp(&b.name));
        entries.dedup_by(|a, b| a.name == b.name);
        let runs = |name: &str| name.ends_with(TRACE_SUFFIX) || name.ends_with(SCENE_SUFFIX);
        if !entries.iter().any(|entry| runs(&entry.name)) {
            return Err(RemoteError::Empty {
                url: self.url.clone(),
            });
        }
        Ok(entries)
    }

    async fn list_prefix(&self) -> Result<Vec<Entry>, RemoteError> {
        let mut entries = Vec::new();
        let mut listed = self.store.list(Some(&self.prefix));
        while let Some(meta) = listed.next().await {
            let meta = meta.map_err(|error| self.error(&error))?;
            if !is_wanted(meta.location.as_ref()) {
                continue;
            }
            if entries.len() >= MAX_FILES {
                return Err(RemoteError::Store {
                    url: self.url.clone(),
                    reason: format!("it has more than {MAX_FILES} files"),
                });
            }
            entries.push(self.entry(meta)?);
        }
        Ok(entries)
    }

    /// The files that the `index.json` of a corpus names.
    async fn list_index(&self) -> Result<Vec<Entry>, RemoteError> {
        let path = self.prefix.clone().join("index.json");
        let found = self.store.get(&path).await;
        let found = found.map_err(|error| self.error(&error))?;
        let refuse = |reason: String| RemoteError::Store {
            url: self.url.clone(),
            reason: format!("index.json: {reason}"),
        };
        if found.meta.size > MAX_INDEX {
            return Err(refuse(format!("it is longer than {MAX_INDEX} bytes")));
        }
        let text = found.bytes().await.map_err(|error| self.error(&error))?;
        let index: Index =
            serde_json::from_slice(&text).map_err(|error| refuse(error.to_string()))?;
        let entries = index.traces.into_iter().map(|trace| {
            Ok(Entry {
                name: self.checked_name(trace.file)?,
                size: trace.bytes,
                tag: trace.blake3.clone(),
                blake3: Some(trace.blake3),
            })
        });
        entries.collect()
    }

    fn entry(&self, meta: ObjectMeta) -> Result<Entry, RemoteError> {
        let location = meta.location.as_ref();
        let under = location.strip_prefix(self.prefix.as_ref());
        let name = match under.map(|name| name.trim_start_matches('/')) {
            // The URL is the file's own.
            Some("") => meta.location.filename().unwrap_or_default(),
            Some(name) => name,
            None => location,
        };
        Ok(Entry {
            name: self.checked_name(name.into())?,
            size: meta.size,
            tag: match &meta.e_tag {
                Some(tag) => etag(tag),
                None => meta.last_modified.to_rfc3339(),
            },
            blake3: None,
        })
    }

    /// A name that stays under a folder, whatever the system.
    fn checked_name(&self, name: String) -> Result<String, RemoteError> {
        let plain = |part: &str| {
            !matches!(part, "" | "." | "..")
                && !part.contains(|c: char| c.is_control() || matches!(c, '\\' | ':'))
        };
        if name.split('/').all(plain) {
            return Ok(name);
        }
        Err(RemoteError::Name {
            url: self.url.clone(),
            name,
        })
    }

    async fn download(&self, entry: &Entry, cache: &Cache) -> Result<(), RemoteError> {
        let changed = |reason: String| RemoteError::Changed {
            url: self.url.clone(),
            file: entry.name.clone(),
            reason,
        };
        let path = if is_wanted(self.prefix.as_ref()) {
            self.prefix.clone()
        } else {
            let under = Path::parse(&entry.name).map_err(|_| RemoteError::Name {
                url: self.url.clone(),
                name: entry.name.clone(),
            })?;
            under
                .parts()
                .fold(self.prefix.clone(), |path, part| path.join(part))
        };
        let found = self.store.get(&path).await;
        let found = found.map_err(|error| self.error(&error))?;
        // A list without entity tags, or an index, has nothing to compare with.
        if let Some(tag) = &found.meta.e_tag
            && entry.tag.starts_with(ETAG)
            && etag(tag) != entry.tag
        {
            return Err(changed("another entity tag".into()));
        }
        let mut file = cache.new_file()?;
        let mut size = 0;
        let mut hasher = blake3::Hasher::new();
        let mut parts = found.into_stream();
        while let Some(part) = parts.next().await {
            let part = part.map_err(|error| self.error(&error))?;
            size += part.len() as u64;
            if size > entry.size {
                break;
            }
            hasher.update(&part);
            file.write_all(&part).map_err(|source| RemoteError::Cache {
                path: file.path().into(),
                source,
            })?;
        }
        if size != entry.size {
            let expected = entry.size;
            return Err(changed(format!("it does not have {expected} bytes")));
        }
        let hash = hasher.finalize().to_string();
        if entry.blake3.as_ref().is_some_and(|wanted| *wanted != hash) {
            return Err(changed(format!("its BLAKE3 is {hash}")));
        }
        cache.keep(file, &self.url, entry)
    }

    fn error(&self, error: &object_store::Error) -> RemoteError {
        classify(&self.url, error)
    }
}

fn is_wanted(name: &str) -> bool {
    let suffixes = EXPECT_SUFFIXES.iter().chain(&STAGE_SUFFIXES);
    [TRACE_SUFFIX, SCENE_SUFFIX]
        .iter()
        .chain(suffixes)
        .any(|suffix| name.ends_with(suffix))
}

/// The store of a URL with credentials from the environment.
fn store_of(
    url: &Url,
    scheme: &ObjectStoreScheme,
) -> Result<Arc<dyn ObjectStore>, object_store::Error> {
    // The provider may be installed already.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let retry = RetryConfig {
        max_retries: 3,
        retry_timeout: RETRY_TIMEOUT,
        ..RetryConfig::default()
    };
    let client = || ClientOptions::new().with_connect_timeout(CONNECT_TIMEOUT);
    Ok(match scheme {
        ObjectStoreScheme::AmazonS3 => Arc::new(
            // The environment also says whether plain HTTP is allowed: options of the client would overwrite that.
            AmazonS3Builder::from_env()
                .with_url(url.as_str())
                .with_retry(retry)
                .build()?,
        ),
        ObjectStoreScheme::GoogleCloudStorage => Arc::new(
            GoogleCloudStorageBuilder::from_env()
                .with_url(url.as_str())
                .with_retry(retry)
                .build()?,
        ),
        ObjectStoreScheme::MicrosoftAzure => Arc::new(
            MicrosoftAzureBuilder::from_env()
                .with_url(url.as_str())
                .with_retry(retry)
                .build()?,
        ),
        ObjectStoreScheme::Http => Arc::new(
            HttpBuilder::new()
                .with_url(&url[..url::Position::BeforePath])
                .with_client_options(client().with_allow_http(true))
                .with_retry(retry)
                .build()?,
        ),
        _ => Arc::new(LocalFileSystem::new()),
    })
}
