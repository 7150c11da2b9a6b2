//! `ac-conform run s3://…` against an S3 server that runs in this process.

use std::{
    collections::BTreeSet,
    fs,
    net::SocketAddr,
    path::{Path, PathBuf},
    process::Command,
    thread::JoinHandle,
};

use ac_golden_traces::corpus;
use hyper_util::{
    rt::{TokioExecutor, TokioIo},
    server::conn::auto::Builder,
};
use s3s::{auth::SimpleAuth, service::S3ServiceBuilder};
use s3s_fs::FileSystem;
use tokio::{net::TcpListener, sync::oneshot};

const KEY: &str = "test-key";
const SECRET: &str = "test-secret";

/// A server over a folder whose subfolders are the buckets.
struct Server {
    address: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    fn start(root: &Path) -> Self {
        let root = root.to_owned();
        let (stop, mut stopped) = oneshot::channel();
        let (started, address) = std::sync::mpsc::channel();
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()
                .expect("a runtime");
            runtime.block_on(async move {
                let mut service = S3ServiceBuilder::new(FileSystem::new(root).expect("a folder"));
                service.set_auth(SimpleAuth::from_single(KEY, SECRET));
                let service = service.build();
                let listener = TcpListener::bind("127.0.0.1:0").await.expect("a port");
                started
                    .send(listener.local_addr().expect("an address"))
                    .expect("it waits");
                loop {
                    let socket = tokio::select! {
                        accepted = listener.accept() => accepted.expect("a connection").0,
                        _ = &mut stopped => return,
                    };
                    let service = service.clone();
                    tokio::spawn(async move {
                        let server = Builder::new(TokioExecutor::new());
                        let _ = server.serve_connection(TokioIo::new(socket), service).await;
                    });
                }
            });
        });
        Self {
            address: address.recv().expect("it starts"),
            stop: Some(stop),
            thread: Some(thread),
        }
    }

    fn stop(&mut self) {
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
        if let Some(thread) = self.thread.take() {
            thread.join().expect("it ended well");
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
    }
}

struct Setting {
    folder: tempfile::TempDir,
    server: Server,
}

impl Setting {
    /// Two traces in a bucket.
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let traces = folder.path().join("store/corpus/nightly/terrain");
        fs::create_dir_all(&traces).expect("a bucket");
        for name in ["cliff-jump", "walk-flat"] {
            let file = format!("{name}.mcap");
            let from = corpus::bundled().join("traces/terrain").join(&file);
            fs::copy(from, traces.join(file)).expect("a bundled trace");
        }
        fs::write(
            folder.path().join("store/corpus/nightly/README.txt"),
            "no trace",
        )
        .unwrap();
        let server = Server::start(&folder.path().join("store"));
        Self { folder, server }
    }

    fn cache(&self) -> PathBuf {
        self.folder.path().join("cache")
    }

    /// Runs `ac-conform run` with this server; answers exit code and output.
    fn run(&self, arguments: &[&str], secret: &str) -> (i32, String) {
        let output = Command::new(env!("CARGO_BIN_EXE_ac-conform"))
            .args(["run", "--mode", "free", "--cache"])
            .arg(self.cache())
            .args(arguments)
            .env("AWS_ENDPOINT", format!("http://{}", self.server.address))
            .env("AWS_ALLOW_HTTP", "true")
            .env("AWS_REGION", "us-east-1")
            .env("AWS_ACCESS_KEY_ID", KEY)
            .env("AWS_SECRET_ACCESS_KEY", secret)
            .env("NO_PROXY", "127.0.0.1")
            .output()
            .expect("the program starts");
        let text = String::from_utf8_lossy(&output.stdout).into_owned()
            + &String::from_utf8_lossy(&output.stderr);
        // The report of an error is broken into lines.
        let text = text.replace(['│', '\n'], " ");
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        (output.status.code().expect("it was not killed"), text)
    }

    /// Names of the cached files.
    fn objects(&self) -> BTreeSet<PathBuf> {
        corpus::find(&self.cache().join("objects"), &[""])
            .expect("the cache is there")
            .into_iter()
            .collect()
    }
}

#[test]
fn a_corpus_is_fetched_once_and_run_from_the_cache() {
    let mut setting = Setting::new();
    let (code, text) = setting.run(&["s3://corpus/nightly"], SECRET);
    assert_eq!(code, 0, "{text}");
    assert!(
        text.contains("terrain/cliff-jump") || text.contains('6'),
        "{text}"
    );
    let fetched = setting.objects();
    assert_eq!(fetched.len(), 2, "the traces and nothing else: {fetched:?}");
    assert_eq!(
        fs::read_dir(setting.cache().join("views")).unwrap().count(),
        0,
        "views are removed"
    );
    // Again: the same files.
    assert_eq!(setting.run(&["s3://corpus/nightly/"], SECRET).0, 0);
    assert_eq!(setting.run(&["s3://corpus/nightly"], SECRET).0, 0);
    // One trace alone.
    let (code, text) = setting.run(&["s3://corpus/nightly/terrain/walk-flat.mcap"], SECRET);
    assert_eq!(code, 0, "{text}");
    // A changed file is fetched again.
    let trace = setting
        .folder
        .path()
        .join("store/corpus/nightly/terrain/walk-flat.mcap");
    fs::copy(
        corpus::bundled().join("traces/terrain/cliff-jump.mcap"),
        &trace,
    )
    .unwrap();
    let before = setting.objects();
    assert_eq!(setting.run(&["s3://corpus/nightly"], SECRET).0, 0);
    assert_eq!(setting.objects().difference(&before).count(), 1);
    // Without the server the copies are run, and a note says so.
    setting.server.stop();
    let (code, text) = setting.run(&["s3://corpus/nightly"], SECRET);
    assert_eq!(code, 0, "{text}");
    assert!(
        text.contains("note: s3://corpus/nightly cannot be reached: running the 2 files"),
        "{text}"
    );
    let (code, text) = setting.run(&["--offline", "s3://corpus/other"], SECRET);
    assert!(
        code == 2 && text.contains("the cache has no copy of it"),
        "{text}"
    );
}

#[test]
fn errors_say_what_and_what_to_do() {
    let setting = Setting::new();
    let (code, text) = setting.run(&["s3://no-such-bucket/x"], SECRET);
    assert!(
        code == 2 && text.contains("there is no such bucket"),
        "{text}"
    );
    let (code, text) = setting.run(&["s3://corpus/nightly"], "wrong");
    assert!(
        code == 2 && text.contains("no permission") && text.contains("AWS_SECRET_ACCESS_KEY"),
        "{text}"
    );
    let (code, text) = setting.run(&["s3://corpus/other"], SECRET);
    assert!(
        code == 2 && text.contains("there is nothing to run"),
        "{text}"
    );
    let (code, text) = setting.run(&["s3://corpus/nightly", "--cache-limit", "1K"], SECRET);
    assert!(code == 2 && text.contains("--cache-limit"), "{text}");
}

#[test]
fn a_folder_may_be_a_url() {
    let setting = Setting::new();
    let url = format!(
        "file://{}",
        setting.folder.path().join("store/corpus").display()
    );
    let (code, text) = setting.run(&[&url], SECRET);
    assert_eq!(code, 0, "{text}");
}
