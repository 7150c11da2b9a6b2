//! What relaying adds to the way of a datagram, and what is lost, against a bare echo on the same machine in the same run.

use std::fmt::Write as _;
use std::net::{SocketAddr, UdpSocket};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde::Serialize;
use tokio::sync::oneshot;

use super::echo::{EchoServer, Packets, log_in, pair, sequence};
use super::{Scratch, write_lines};
use crate::cli::FOUND;
use crate::clock::Clock;
use crate::counters::Counters;
use crate::disk::{Disk, DiskConfig, Files};
use crate::error::RecordError;
use crate::format::Stream;
use crate::proxy::{Proxy, ProxyConfig, ProxyReport};
use crate::sockets;

/// Arguments of `ac-record bench`.
#[derive(clap::Args)]
pub struct BenchArgs {
    /// Datagrams per second, one measurement each.
    #[arg(long, value_delimiter = ',', default_value = "1000,10000,30000,100000")]
    rates: Vec<u32>,
    /// Seconds of each measurement.
    #[arg(long, default_value_t = 3.0)]
    seconds: f64,
    /// Where the numbers go, as lines of JSON.
    #[arg(long, default_value = "target/recorder-bench.jsonl")]
    lines: PathBuf,
}

/// One way at one rate.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct Way {
    /// Datagrams sent.
    sent: u64,
    /// Datagrams that did not come back.
    lost: u64,
    /// Median time there and back, µs.
    p50_us: f64,
    /// 99 of 100 came back within, µs.
    p99_us: f64,
}

#[derive(Debug, Serialize)]
struct Line {
    rate: u32,
    seconds: f64,
    direct: Way,
    relayed: Way,
    added_p50_us: f64,
    added_p99_us: f64,
    /// Datagrams that passed the relay, both directions.
    passed: u64,
    recorded: u64,
    unwritten: u64,
    system_dropped: u64,
    /// Datagrams that the writer thread alone takes per second.
    writer_per_second: f64,
    cores: usize,
}

/// Measures all rates.
///
/// # Errors
/// A socket or file cannot be opened.
pub fn run(args: &BenchArgs) -> Result<(String, u8), RecordError> {
    let mut lines = Vec::new();
    let writer_per_second = writer_alone()?;
    for &rate in &args.rates {
        let line = Line {
            writer_per_second,
            ..measure(rate, args.seconds)?
        };
        tracing::info!(?line, "measured");
        lines.push(line);
    }
    write_lines(&args.lines, &lines)?;
    let mut text = String::from(
        "rate/s   direct p50 p99 us   relayed p50 p99 us   added p50 p99 us   lost direct/relayed   unwritten\n",
    );
    for l in &lines {
        let _ = writeln!(
            text,
            "{:>6} {:>10.0} {:>6.0} {:>13.0} {:>6.0} {:>12.0} {:>6.0} {:>14}/{:<8} {:>10}",
            l.rate,
            l.direct.p50_us,
            l.direct.p99_us,
            l.relayed.p50_us,
            l.relayed.p99_us,
            l.added_p50_us,
            l.added_p99_us,
            l.direct.lost,
            l.relayed.lost,
            l.unwritten
        );
    }
    let writer = lines.first().map_or(0.0, |l| l.writer_per_second);
    let _ = writeln!(
        text,
        "the writer alone takes {writer:.0} datagrams per second"
    );
    let unwritten = lines.iter().any(|l| l.unwritten > 0);
    Ok((text, if unwritten { FOUND } else { 0 }))
}

fn measure(rate: u32, seconds: f64) -> Result<Line, RecordError> {
    let scratch = Scratch::new("bench")?;
    let server = EchoServer::start()?;
    let direct = one_way(server.address, rate, seconds)?;
    let listen = {
        let (first, _second) = pair()?;
        first.local_addr().map_err(|source| RecordError::Socket {
            address: server.address,
            source,
        })?
    };
    let output = scratch.0.join(format!("{rate}.mcap"));
    let relay = RunningProxy::start(ProxyConfig::new(listen, server.address, output))?;
    let relayed = one_way(listen, rate, seconds);
    let report = relay.stop();
    let relayed = relayed?;
    Ok(Line {
        rate,
        seconds,
        direct,
        relayed,
        added_p50_us: relayed.p50_us - direct.p50_us,
        added_p99_us: relayed.p99_us - direct.p99_us,
        passed: report.counts.to_server + report.counts.to_clients,
        recorded: report.counts.recorded,
        unwritten: report.counts.unwritten(),
        system_dropped: report.counts.system_dropped,
        writer_per_second: 0.0,
        cores: std::thread::available_parallelism().map_or(0, usize::from),
    })
}

/// What the writer thread sustains: redaction, index, compression, file.
fn writer_alone() -> Result<f64, RecordError> {
    const COUNT: u32 = 200_000;
    let scratch = Scratch::new("writer")?;
    let config = DiskConfig {
        queue: COUNT as usize,
        queue_bytes: 1 << 30,
        ..DiskConfig::new(scratch.0.join("writer.mcap"))
    };
    let counters = Arc::<Counters>::default();
    let disk = Disk::start(config, Box::new(Files), Clock::new(), counters)?;
    let stream = Stream {
        client: 0,
        to_server: true,
        next_port: false,
    };
    let mut packets = Packets::default();
    let start = Instant::now();
    for number in 2..COUNT + 2 {
        disk.record(stream, u64::from(number), None, packets.packet(number));
    }
    disk.finish();
    Ok(f64::from(COUNT) / start.elapsed().as_secs_f64())
}

/// A proxy on a thread of its own, as the program runs it.
struct RunningProxy {
    stop: oneshot::Sender<()>,
    thread: std::thread::JoinHandle<ProxyReport>,
}

impl RunningProxy {
    fn start(config: ProxyConfig) -> Result<Self, RecordError> {
        let (stop, stopped) = oneshot::channel();
        let (ready, opened) = std::sync::mpsc::channel();
        let address = config.listen;
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build();
            let opened = runtime
                .map_err(|source| RecordError::Socket { address, source })
                .and_then(|runtime| {
                    let proxy = runtime.block_on(async { Proxy::open(&config) })?;
                    Ok((runtime, proxy))
                });
            match opened {
                Ok((runtime, proxy)) => {
                    let _ = ready.send(Ok(()));
                    runtime.block_on(proxy.run(async {
                        let _ = stopped.await;
                    }))
                }
                Err(error) => {
                    let _ = ready.send(Err(error));
                    ProxyReport::default()
                }
            }
        });
        match opened.recv() {
            Ok(Ok(())) => Ok(Self { stop, thread }),
            Ok(Err(error)) => Err(error),
            Err(_) => Err(RecordError::Address {
                text: address.to_string(),
                reason: "the proxy did not start".into(),
            }),
        }
    }

    fn stop(self) -> ProxyReport {
        let _ = self.stop.send(());
        self.thread.join().unwrap_or_default()
    }
}

/// Sends at a rate and takes the time until each datagram is back.
fn one_way(to: SocketAddr, rate: u32, seconds: f64) -> Result<Way, RecordError> {
    let socket = sockets::bind_blocking(([127, 0, 0, 1], 0).into())?;
    let until = Instant::now() + Duration::from_secs(5);
    if !log_in(&socket, to, until) {
        return Err(RecordError::Address {
            text: to.to_string(),
            reason: "no answer to the login".into(),
        });
    }
    let count = (f64::from(rate) * seconds) as usize;
    let sent: Arc<Vec<AtomicU64>> = Arc::new((0..count).map(|_| AtomicU64::new(0)).collect());
    let start = Instant::now();
    let done = Arc::<AtomicBool>::default();
    let receiver = {
        let failed = |source| RecordError::Socket {
            address: to,
            source,
        };
        let (socket, sent, done) = (
            socket.try_clone().map_err(failed)?,
            sent.clone(),
            done.clone(),
        );
        std::thread::spawn(move || receive(&socket, &sent, start, &done))
    };
    let mut packets = Packets::default();
    let (mut next, mut number) = (0, 0);
    while next < count {
        let due = ((start.elapsed().as_secs_f64() * f64::from(rate)) as usize).min(count);
        while next < due {
            let packet = packets.packet(next as u32);
            sent[next].store(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
            number += u64::from(socket.send_to(packet, to).is_ok());
            next += 1;
        }
        std::thread::sleep(Duration::from_micros(50));
    }
    std::thread::sleep(Duration::from_millis(500));
    done.store(true, Ordering::Relaxed);
    let mut times = receiver.join().unwrap_or_default();
    times.sort_unstable();
    let at = |share: f64| {
        let index = ((times.len() as f64 * share) as usize).min(times.len().saturating_sub(1));
        times.get(index).map_or(f64::NAN, |&ns| ns as f64 / 1e3)
    };
    Ok(Way {
        sent: number,
        lost: number.saturating_sub(times.len() as u64),
        p50_us: at(0.5),
        p99_us: at(0.99),
    })
}

/// Times there and back, ns.
fn receive(socket: &UdpSocket, sent: &[AtomicU64], start: Instant, done: &AtomicBool) -> Vec<u64> {
    let _ = socket.set_read_timeout(Some(Duration::from_millis(20)));
    let (mut buffer, mut times) = ([0; 2048], Vec::with_capacity(sent.len()));
    while !done.load(Ordering::Relaxed) {
        let Ok((n, _)) = socket.recv_from(&mut buffer) else {
            continue;
        };
        let now = start.elapsed().as_nanos() as u64;
        if let Some(at) = sequence(&buffer[..n]).and_then(|s| sent.get(s as usize)) {
            times.push(now.saturating_sub(at.load(Ordering::Relaxed)));
        }
    }
    times
}
