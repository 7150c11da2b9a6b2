use std::io;
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

use super::*;
use crate::format::{Recording, read_bytes};

/// Files by path, with what was written into them.
type Written = Arc<Mutex<Vec<(PathBuf, Vec<u8>)>>>;

/// Files in memory on a disk of limited size and speed.
#[derive(Clone, Default)]
struct Memory {
    files: Written,
    room: Arc<AtomicUsize>,
    delay: Duration,
}

struct Open(Memory, usize);

impl Medium for Open {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        std::thread::sleep(self.0.delay);
        let room = self.0.room.load(Ordering::Relaxed);
        let fits = bytes.len().min(room);
        self.0.room.fetch_sub(fits, Ordering::Relaxed);
        // As a real disk does: a part may be written before it is full.
        self.0.files.lock().expect("no panic")[self.1]
            .1
            .extend(&bytes[..fits]);
        if fits < bytes.len() {
            return Err(io::ErrorKind::StorageFull.into());
        }
        Ok(())
    }

    fn truncate(&mut self, length: u64) -> io::Result<()> {
        let mut files = self.0.files.lock().expect("no panic");
        let before = files[self.1].1.len();
        files[self.1].1.truncate(length as usize);
        let freed = before - files[self.1].1.len();
        self.0.room.fetch_add(freed, Ordering::Relaxed);
        Ok(())
    }

    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Storage for Memory {
    fn create(&mut self, path: &Path) -> io::Result<Box<dyn Medium>> {
        let mut files = self.files.lock().expect("no panic");
        if files.iter().any(|f| f.0 == path) {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        files.push((path.into(), Vec::new()));
        Ok(Box::new(Open(self.clone(), files.len() - 1)))
    }

    fn remove(&mut self, _path: &Path) {}
}

impl Memory {
    fn with(room: usize, delay: Duration) -> Self {
        let memory = Self {
            delay,
            ..Self::default()
        };
        memory.room.store(room, Ordering::Relaxed);
        memory
    }

    fn recordings(&self) -> Vec<(PathBuf, Recording)> {
        let files = self.files.lock().expect("no panic");
        files
            .iter()
            .filter(|f| !f.1.is_empty())
            .map(|(path, bytes)| (path.clone(), read_bytes(path, bytes).expect("a recording")))
            .collect()
    }
}

const STREAM: Stream = Stream {
    client: 0,
    to_server: false,
    next_port: false,
};

fn config() -> DiskConfig {
    DiskConfig {
        options: WriterOptions {
            compress: false,
            ..WriterOptions::default()
        },
        flush: Duration::from_millis(10),
        ..DiskConfig::new("session.mcap".into())
    }
}

fn start(config: DiskConfig, memory: &Memory) -> (Disk, Arc<Counters>) {
    let counters = Arc::<Counters>::default();
    let disk = Disk::start(
        config,
        Box::new(memory.clone()),
        Clock::new(),
        counters.clone(),
    );
    (disk.expect("room for the start"), counters)
}

fn wait_until(what: impl Fn() -> bool) {
    let start = Instant::now();
    while !what() {
        assert!(start.elapsed() < Duration::from_secs(20), "in time");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_full_disk_is_counted_and_recording_goes_on_when_there_is_room() {
    let memory = Memory::with(20_000, Duration::ZERO);
    let (disk, counters) = start(config(), &memory);
    let mut sent = 0;
    while counters.counts().unwritten_failed < 50 {
        disk.record(STREAM, sent, None, &[7; 400]);
        sent += 1;
        std::thread::sleep(Duration::from_micros(200));
    }
    memory.room.store(1 << 20, Ordering::Relaxed);
    wait_until(|| counters.counts().files == 2);
    for _ in 0..20 {
        disk.record(STREAM, sent, None, &[8; 400]);
        sent += 1;
    }
    disk.finish();
    let counts = counters.counts();
    assert_eq!(counts.recorded + counts.unwritten(), sent);
    let recordings = memory.recordings();
    let names: Vec<_> = recordings.iter().map(|r| r.0.clone()).collect();
    assert_eq!(
        names,
        [PathBuf::from("session.mcap"), "session-0002.mcap".into()]
    );
    assert!(recordings[0].1.damage.is_some() && recordings[1].1.damage.is_none());
    let numbers: Vec<_> = recordings
        .iter()
        .flat_map(|r| r.1.packets.iter().map(|p| p.number))
        .collect();
    // What the counters say is there is there, and what is missing is where the numbers are missing.
    assert_eq!(numbers.len() as u64, counts.recorded);
    assert!(numbers.is_sorted() && numbers.last() == Some(&(sent as u32 - 1)));
}

#[test]
fn a_slow_disk_holds_nobody_up() {
    let memory = Memory::with(1 << 30, Duration::from_millis(30));
    let config = DiskConfig {
        queue: 16,
        flush: Duration::ZERO,
        ..config()
    };
    let (disk, counters) = start(config, &memory);
    let before = Instant::now();
    for i in 0..5000 {
        disk.record(STREAM, i, None, &[7; 100]);
    }
    // Writing all of them would take minutes.
    assert!(before.elapsed() < Duration::from_secs(5));
    disk.finish();
    let counts = counters.counts();
    assert!(counts.unwritten_slow > 0);
    assert_eq!(counts.recorded + counts.unwritten_slow, 5000);
    let recordings = memory.recordings();
    assert_eq!(recordings[0].1.packets.len() as u64, counts.recorded);
}

#[test]
fn too_many_bytes_do_not_wait_either() {
    let memory = Memory::with(1 << 30, Duration::from_millis(20));
    let config = DiskConfig {
        queue_bytes: 10_000,
        flush: Duration::ZERO,
        ..config()
    };
    let (disk, counters) = start(config, &memory);
    for i in 0..200 {
        disk.record(STREAM, i, None, &[7; 1000]);
    }
    disk.finish();
    let counts = counters.counts();
    assert!(counts.unwritten_slow > 0 && counts.recorded > 0);
}

#[test]
fn files_are_rotated_by_size_and_numbers_go_on() {
    let memory = Memory::with(1 << 30, Duration::ZERO);
    let config = DiskConfig {
        rotation: Rotation {
            size: Some(3000),
            every: None,
        },
        flush: Duration::ZERO,
        ..config()
    };
    let (disk, _) = start(config, &memory);
    for i in 0..40 {
        disk.record(STREAM, i, Some(i + 1), &[7; 400]);
    }
    let report = disk.finish();
    assert!(report.files.len() > 3 && report.leaks.is_empty());
    let recordings = memory.recordings();
    assert!(recordings.iter().all(|r| r.1.damage.is_none()));
    let numbers: Vec<_> = recordings
        .iter()
        .flat_map(|r| r.1.packets.iter().map(|p| p.number))
        .collect();
    assert_eq!(numbers, (0..40).collect::<Vec<u32>>());
}

#[test]
fn files_are_rotated_by_time() {
    let memory = Memory::with(1 << 30, Duration::ZERO);
    let config = DiskConfig {
        rotation: Rotation {
            size: None,
            every: Some(Duration::from_millis(50)),
        },
        ..config()
    };
    let (disk, counters) = start(config, &memory);
    disk.record(STREAM, 1, None, b"first");
    wait_until(|| counters.counts().files >= 3);
    disk.record(STREAM, 2, None, b"last");
    disk.finish();
    let recordings = memory.recordings();
    assert!(recordings.iter().all(|r| r.1.damage.is_none()));
    let packets: usize = recordings.iter().map(|r| r.1.packets.len()).sum();
    assert_eq!(packets, 2);
}

#[test]
fn nothing_stays_in_memory_for_longer_than_the_bound() {
    let memory = Memory::with(1 << 30, Duration::ZERO);
    let (disk, _) = start(config(), &memory);
    for i in 0..3 {
        disk.record(STREAM, i, None, b"datagram");
        wait_until(|| memory.recordings()[0].1.packets.len() as u64 == i + 1);
    }
    disk.finish();
}

#[test]
fn names_of_parts() {
    let first = Path::new("/a/b.c.mcap");
    assert_eq!(part_path(first, 1), first);
    assert_eq!(part_path(first, 2), Path::new("/a/b.c-0002.mcap"));
    assert_eq!(part_path(Path::new("plain"), 12), Path::new("plain-0012"));
}
