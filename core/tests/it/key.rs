//! Links with a key: the tags of the reference, the keys of sessions, and counters.

use foldpath_core::wire::frame;
use foldpath_core::wire::key::{self, Channel, Direction, Key, Nonces};
use foldpath_core::wire::message::{Capacity, Command, ToDevice, ToHost};
use foldpath_test_support::Random;
use rand_core::Rng;
use serde::Serialize;

use crate::wire::{documented, hex};

/// The tags of the reference implementation of SipHash-2-4 (`vectors.h`) for the key 00 01 ... 0f and the messages of 0
/// to 63 bytes 00 01 02 ...; the one of 15 bytes is the example of the paper's appendix.
#[rustfmt::skip]
const VECTORS: [u64; 64] = [
    0x726f_db47_dd0e_0e31, 0x74f8_39c5_93dc_67fd, 0x0d6c_8009_d9a9_4f5a, 0x8567_6696_d7fb_7e2d,
    0xcf27_94e0_2771_87b7, 0x1876_5564_cd99_a68d, 0xcbc9_466e_58fe_e3ce, 0xab02_00f5_8b01_d137,
    0x93f5_f579_9a93_2462, 0x9e00_82df_0ba9_e4b0, 0x7a5d_bbc5_94dd_b9f3, 0xf4b3_2f46_226b_ada7,
    0x751e_8fbc_860e_e5fb, 0x14ea_5627_c084_3d90, 0xf723_ca90_8e7a_f2ee, 0xa129_ca61_49be_45e5,
    0x3f2a_cc7f_57c2_9bdb, 0x699a_e9f5_2cbe_4794, 0x4bc1_b3f0_968d_d39c, 0xbb6d_c91d_a779_61bd,
    0xbed6_5cf2_1aa2_ee98, 0xd0f2_cbb0_2e3b_67c7, 0x9353_6795_e3a3_3e88, 0xa80c_038c_cd5c_cec8,
    0xb8ad_50c6_f649_af94, 0xbce1_92de_8a85_b8ea, 0x17d8_35b8_5bbb_15f3, 0x2f2e_6163_076b_cfad,
    0xde4d_aaac_a71d_c9a5, 0xa6a2_5066_8795_6571, 0xad87_a353_5c49_ef28, 0x32d8_92fa_d841_c342,
    0x7127_512f_72f2_7cce, 0xa7f3_2346_f959_78e3, 0x12e0_b01a_bb05_1238, 0x15e0_34d4_0fa1_97ae,
    0x314d_ffbe_0815_a3b4, 0x0279_90f0_2962_3981, 0xcadc_d4e5_9ef4_0c4d, 0x9abf_d876_6a33_735c,
    0x0e3e_a96b_5304_a7d0, 0xad0c_42d6_fc58_5992, 0x1873_06c8_9bc2_15a9, 0xd4a6_0abc_f379_2b95,
    0xf935_451d_e4f2_1df2, 0xa953_8f04_1975_5787, 0xdb9a_cddf_f56c_a510, 0xd06c_98cd_5c09_75eb,
    0xe612_a3cb_9ecb_a951, 0xc766_e62c_fcad_af96, 0xee64_435a_9752_fe72, 0xa192_d576_b245_165a,
    0x0a87_87bf_8ecb_74b2, 0x81b3_e73d_20b4_9b6f, 0x7fa8_220b_a3b2_ecea, 0x2457_31c1_3ca4_2499,
    0xb78d_bfaf_3a8d_83bd, 0xea1a_d565_322a_1a0b, 0x60e6_1c23_a379_5013, 0x6606_d7e4_4628_2b93,
    0x6ca4_ecb1_5c5f_91e1, 0x9f62_6da1_5c96_25f3, 0xe51b_3860_8ef2_5f57, 0x958a_324c_eb06_4572,
];

fn key() -> Key {
    Key::new(core::array::from_fn(|byte| u8::try_from(byte).unwrap()))
}

#[test]
fn tags_are_those_of_the_reference() {
    let bytes: Vec<u8> = (0..64).collect();
    for (length, tag) in VECTORS.into_iter().enumerate() {
        assert_eq!(key().tag(&bytes[..length]), tag, "{length} bytes");
    }
}

/// Returns both ends of a session after the host has sent this number of frames, and the controller as many.
fn ends(nonces: Nonces, session: u32, sent: u32) -> [Channel; 2] {
    [Direction::ToDevice, Direction::ToHost]
        .map(|way| Channel::new(&key(), way, nonces, session, sent))
}

fn closed(channel: &mut Channel, message: &[u8]) -> Option<Vec<u8>> {
    let mut buffer = [0; 64];
    buffer[..message.len()].copy_from_slice(message);
    let length = channel.close(&mut buffer, message.len())?;
    channel.advance();
    Some(buffer[..length].to_vec())
}

#[test]
fn a_key_of_a_session_depends_on_all_that_it_is_made_of() {
    let nonces = Nonces { host: 1, device: 2 };
    let mut keys = vec![key()];
    for way in [Direction::ToDevice, Direction::ToHost] {
        for nonces in [
            nonces,
            Nonces { host: 2, device: 1 },
            Nonces {
                host: 1 << 32,
                ..nonces
            },
            Nonces {
                device: 2 << 32,
                ..nonces
            },
            Nonces::default(),
        ] {
            for session in [0, 1, 1 << 24] {
                keys.push(key().of(way, nonces, session));
            }
        }
    }
    for (place, one) in keys.iter().enumerate() {
        assert!(!keys[..place].contains(one), "{place}");
        // The halves differ as well.
        let (low, high) = one.bytes().split_at(8);
        assert_ne!(low, high);
    }
    assert_eq!(format!("{:?}", key()), "Key");
}

#[test]
fn a_frame_is_taken_once_and_only_by_the_other_end_of_its_session() {
    let nonces = Nonces { host: 1, device: 2 };
    let [mut host, mut device] = ends(nonces, 5, 0);
    let first = closed(&mut host, b"first").unwrap();
    let second = closed(&mut host, b"second").unwrap();
    let [mut reflected, mut other] = [host, ends(nonces, 6, 0)[1]];
    assert_eq!(reflected.take(&first), None);
    assert_eq!(other.take(&first), None);
    assert_eq!(device.take(&second), Some(&b"second"[..]));
    // The first one is late, and the second one was taken.
    assert_eq!(device.take(&first), None);
    assert_eq!(device.take(&second), None);
    assert_eq!(ends(nonces, 5, 0)[1].take(&first), Some(&b"first"[..]));
}

#[test]
fn each_changed_bit_is_noticed() {
    let [mut host, device] = ends(Nonces { host: 1, device: 2 }, 5, 0);
    let frame = closed(&mut host, &[7; 30]).unwrap();
    for bit in 0..frame.len() * 8 {
        let mut changed = frame.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        assert_eq!({ device }.take(&changed), None, "bit {bit}");
    }
    for length in 0..frame.len() {
        assert_eq!({ device }.take(&frame[..length]), None);
        assert_eq!({ device }.take(&frame[length + 1..]), None);
    }
    assert_eq!({ device }.take(&[&frame[..], &[0]].concat()), None);
    assert_eq!({ device }.take(&frame), Some(&[7; 30][..]));
}

/// A session ends before a counter comes again.
#[test]
fn counters_do_not_wrap() {
    let [mut host, mut device] = ends(Nonces { host: 1, device: 2 }, 5, u32::MAX - 2);
    let early = closed(&mut ends(Nonces { host: 1, device: 2 }, 5, 0)[0], b"early").unwrap();
    let frames: Vec<_> = core::iter::from_fn(|| closed(&mut host, b"frame"))
        .take(10)
        .collect();
    assert_eq!(frames.len(), 2);
    assert!(frames[1][5..].starts_with(&[255; 4]));
    assert_eq!(device.take(&frames[1]), Some(&b"frame"[..]));
    for frame in [&early, &frames[0], &frames[1]] {
        assert_eq!(device.take(frame), None);
    }
    for _ in 0..4 {
        assert_eq!(closed(&mut host, b"frame"), None);
    }
}

#[test]
fn there_has_to_be_room_for_counter_and_tag() {
    let [host, _] = ends(Nonces::default(), 5, 0);
    let mut rng = Random::new(93);
    for length in 0..64 {
        let mut buffer = [0; 64];
        rng.fill_bytes(&mut buffer);
        let fits = length + 12 <= 64;
        assert_eq!(host.close(&mut buffer, length), fits.then_some(length + 12));
    }
}

/// Returns the bytes of a frame that ends with this counter and the tag of `key`. They are made from a frame without a key,
/// which begins in the same way.
fn tagged(
    session: u32,
    message: &impl Serialize,
    epoch: Option<u8>,
    counter: u32,
    key: &Key,
) -> Vec<u8> {
    let mut buffer = [0; 64];
    let plain = frame::seal(session, message, &mut buffer).unwrap();
    let mut bytes = plain[..plain.len() - 4].to_vec();
    bytes.extend(epoch);
    bytes.extend(counter.to_le_bytes());
    let tag = key.tag(&bytes);
    bytes.extend(tag.to_le_bytes());
    bytes
}

#[test]
fn the_protocols_frames_with_a_key_are_as_they_are() {
    let nonces = Nonces {
        host: 0x0000_0009_0000_0005,
        device: 300,
    };
    let [to_device, to_host] = [Direction::ToDevice, Direction::ToHost];
    let greetings = [to_device, to_host].map(|way| key().of(way, Nonces::default(), 0));
    let session = [to_device, to_host].map(|way| key().of(way, nonces, 6));
    let (version, schema, id) = (3, 0x1234_5678, 5);
    let hello = ToDevice::Hello {
        version,
        schema,
        id,
    };
    let welcome = ToHost::Welcome {
        id,
        session: 6,
        nonce: 300,
        epoch: 4,
        capacity: Capacity {
            groups: 2,
            hinges: 1104,
            spokes: 16,
            knots: 64,
        },
    };
    let start = ToDevice::Command {
        number: 1,
        command: Command::Start,
    };
    let hello = tagged(0, &hello, None, 9, &greetings[0]);
    let start = tagged(6, &start, Some(4), 1, &session[0]);
    let lines = [
        (key().bytes().to_vec(), "shared key"),
        (
            greetings[0].bytes().to_vec(),
            "key of greetings of the host",
        ),
        (hello, "Hello of the host of nonce 0000000900000005"),
        (
            greetings[1].bytes().to_vec(),
            "key of greetings of the controller",
        ),
        (
            tagged(0, &welcome, None, 9, &greetings[1]),
            "Welcome of the controller of nonce 300, which offers session 6",
        ),
        (session[0].bytes().to_vec(), "key of session 6, of the host"),
        (
            start.clone(),
            "Command 1, Start, in epoch 4, with counter 1",
        ),
        (
            session[1].bytes().to_vec(),
            "key of session 6, of the controller",
        ),
    ];
    let lines = lines.map(|(bytes, what)| format!("{}| {what}", hex(&bytes)));
    assert_eq!(documented(2), lines, "\n{}\n", lines.join("\n"));

    let mut end = Channel::new(&key(), to_host, nonces, 6, 0);
    assert_eq!(end.take(&start), Some(&start[..start.len() - 12]));
}

/// A frame is fresh in the epoch that it tells and in the next one, whatever their lowest bits are, unless its session was
/// silent for so long that the bits may have come again.
#[test]
fn a_frame_is_fresh_for_two_epochs() {
    for first in [0, 1, 127, 254, 255, 256, 300, u32::MAX - 600] {
        let bits = key::low_byte(first);
        for later in 0..600 {
            let now = first + later;
            let silent = key::is_fresh(bits, now, first);
            assert_eq!(silent, later <= 1, "{first}, {later} later");
            let alive = key::is_fresh(bits, now, now);
            assert_eq!(alive, later % 256 <= 1, "{first}, {later} later");
        }
        // The frame is not of a later epoch.
        assert!(!key::is_fresh(bits.wrapping_add(1), first, first));
    }
    assert_eq!(key::epoch(0), 0);
    assert_eq!([(1 << 21) - 1, 1 << 21].map(key::epoch), [0, 1]);
    assert_eq!(key::low_byte(key::epoch(300 << 21)), 44);
}
