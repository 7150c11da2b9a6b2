//! From a captured frame to what is in it: a UDP datagram, a fragment of one, or nothing of interest.

use std::net::{IpAddr, SocketAddr};

use etherparse::{EtherType, Ipv6ExtensionSlice, NetSlice, SlicedPacket, ip_number};

use super::{Datagram, FragmentKey};

const ETHERNET: i32 = 1;
const NULL: i32 = 0;
const LOOP: i32 = 108;
const RAW: [i32; 4] = [12, 101, 228, 229];
const LINUX_SLL: i32 = 113;
const LINUX_SLL2: i32 = 276;

/// What a frame holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content<'a> {
    /// A whole datagram.
    Udp(Datagram<'a>),
    /// A fragment of an IP packet with UDP.
    Fragment {
        /// Whose.
        key: FragmentKey,
        /// Where it belongs, bytes.
        offset: usize,
        /// Others come after it.
        more: bool,
        /// Its part of the IP payload.
        bytes: &'a [u8],
    },
    /// Something else, or a link layer that is not read.
    Other,
    /// Headers that are damaged.
    Unreadable,
}

/// What is in a frame of a link layer (`LINKTYPE_` numbers).
pub fn content_of(link: i32, frame: &[u8]) -> Content<'_> {
    let sliced = match link {
        ETHERNET => SlicedPacket::from_ethernet(frame),
        LINUX_SLL => SlicedPacket::from_linux_sll(frame),
        LINUX_SLL2 => match (frame.first_chunk(), frame.get(20..)) {
            (Some(protocol), Some(rest)) => {
                SlicedPacket::from_ether_type(EtherType(u16::from_be_bytes(*protocol)), rest)
            }
            _ => return Content::Unreadable,
        },
        // Four bytes of address family, in an order that depends on the machine; the IP version says the same.
        NULL | LOOP => SlicedPacket::from_ip(frame.get(4..).unwrap_or_default()),
        _ if RAW.contains(&link) => SlicedPacket::from_ip(frame),
        _ => return Content::Other,
    };
    sliced.map_or(Content::Unreadable, |packet| {
        packet.net.map_or(Content::Other, |net| of_ip(&net))
    })
}

fn of_ip<'a>(net: &NetSlice<'a>) -> Content<'a> {
    let (from, to, payload, fragment): (IpAddr, IpAddr, _, _) = match net {
        NetSlice::Ipv4(ip) => {
            let header = ip.header();
            let fragment = (
                u32::from(header.identification()),
                header.fragments_offset().value(),
                header.more_fragments(),
            );
            (
                header.source_addr().into(),
                header.destination_addr().into(),
                ip.payload().clone(),
                Some(fragment),
            )
        }
        NetSlice::Ipv6(ip) => {
            let header = ip.header();
            let mut extensions = ip.extensions().clone().into_iter();
            let fragment = extensions.find_map(|extension| match extension {
                Ipv6ExtensionSlice::Fragment(f) => Some((
                    f.identification(),
                    f.fragment_offset().value(),
                    f.more_fragments(),
                )),
                _ => None,
            });
            (
                header.source_addr().into(),
                header.destination_addr().into(),
                ip.payload().clone(),
                fragment,
            )
        }
        NetSlice::Arp(_) => return Content::Other,
    };
    if payload.ip_number != ip_number::UDP {
        return Content::Other;
    }
    match (payload.fragmented, fragment) {
        (true, Some((id, offset, more))) => Content::Fragment {
            key: FragmentKey { from, to, id },
            // The field counts in units of eight bytes.
            offset: usize::from(offset) * 8,
            more,
            bytes: payload.payload,
        },
        _ => udp(from, to, payload.payload).map_or(Content::Unreadable, Content::Udp),
    }
}

/// The datagram in an IP payload.
pub(super) fn udp(from: IpAddr, to: IpAddr, payload: &[u8]) -> Option<Datagram<'_>> {
    let field = |at: usize| Some(u16::from_be_bytes(*payload.get(at..)?.first_chunk()?));
    let length = usize::from(field(4)?);
    Some(Datagram {
        from: SocketAddr::new(from, field(0)?),
        to: SocketAddr::new(to, field(2)?),
        bytes: payload.get(8..length)?,
    })
}
