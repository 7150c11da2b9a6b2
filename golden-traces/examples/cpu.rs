//! x
use ac_client::frame::*; use ac_golden_traces::{corpus,record::*,trace::*};
fn cpu()->f64{ let s=std::fs::read_to_string("/proc/thread-self/schedstat").unwrap(); s.split(' ').next().unwrap().parse::<f64>().unwrap()/1e9 }
fn main(){
 let files:Vec<Vec<u8>>=corpus::find(&corpus::bundled().join("traces"),&[".mcap"]).unwrap().iter().map(|p|std::fs::read(p).unwrap()).collect();
 let mut recs=vec![]; let t=cpu();
 let mut n=0usize;
 for f in &files { let mut r=TraceReader::new(&f[..],std::path::Path::new("x")).unwrap(); r.select(|k|matches!(k,ChannelKind::Expect(_))); let mut s=FrameStates::new(); while let Some(_)=r.next_event(&mut s).unwrap(){ n+=s.len(); } }
 let d=cpu()-t; println!("files {n} records {d:.3}s {:.0}/s",n as f64/d);
 for f in &files[..60] { let mut r=TraceReader::new(&f[..],std::path::Path::new("x")).unwrap(); r.select(|k|matches!(k,ChannelKind::Expect(_))); let mut s=FrameStates::new(); while let Some(_)=r.next_event(&mut s).unwrap(){ recs.extend_from_slice(&s);} }
 let lines:Vec<Vec<u8>>=recs.iter().map(|r|{let mut v=vec![];write_line(&mut v,r);v}).collect();
 let bytes:usize=lines.iter().map(|l|l.len()).sum();
 let mut st=FrameState::default();
 let t=cpu(); for l in &lines{ read_line(l,Unknown::Refuse,&mut st).unwrap(); std::hint::black_box(&st);} let d=cpu()-t; println!("lines {} {:.0}/s {:.0} MB/s",lines.len(),lines.len() as f64/d, bytes as f64/d/1e6);
 let mut v=vec![]; let t=cpu(); for r in &recs{ v.clear(); write_line(&mut v,r); std::hint::black_box(&v);} let d=cpu()-t; println!("write {:.0}/s",recs.len() as f64/d);
}
