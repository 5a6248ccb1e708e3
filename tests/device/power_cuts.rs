//! The power goes at every word write and every erase of a save. Afterwards the store finds the old
//! or the new set whole.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use simulator::flash::{CutRemains, PowerCut, SECTOR, SimulatedFlash};
use stiction::parameters::store::{SaveError, Store};
use stiction::parameters::{DecodeError, ROOM};
use stiction::servo::{Boot, State};

use crate::fixture::{blank, parameters, plans, srnf, stored};

/// Remains that a cut may leave of a word or a sector: nothing, everything, and some patterns in
/// between.
fn remains() -> impl Iterator<Item = CutRemains> {
    let some = (1..=6u64).map(|seed| CutRemains::Some(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15)));
    [CutRemains::Untouched, CutRemains::Finished].into_iter().chain(some)
}

/// Cuts a save at every operation; returns how many times, and how often the new set was found.
fn cut_at_each(
    before: &Store<SimulatedFlash>,
    old: Option<&stiction::Parameters>,
    new: &stiction::Parameters,
) -> (u32, u32) {
    let mut whole = before.clone();
    whole.flash().revive();
    whole.save(new).unwrap();
    let operations = whole.flash().operations();
    let (mut cuts, mut news) = (0, 0);
    for (after, remains) in
        (0..operations).flat_map(|after| remains().map(move |remains| (after, remains)))
    {
        let mut store = before.clone();
        store.flash().cut(PowerCut { after, remains });
        assert_eq!(store.save(new), Err(SaveError::Flash), "{after} {remains:?}");
        store.flash().revive();
        cuts += 1;
        match store.load() {
            Ok(found) if found == *new => news += 1,
            Ok(found) => assert_eq!(Some(&found), old, "{after} {remains:?}"),
            // The store may be empty only if it was so before.
            Err(_) => assert_eq!(old, None, "{after} {remains:?}"),
        }
        // A save works again, whatever the cut has left.
        store.save(new).unwrap();
        assert_eq!(store.load().as_ref(), Ok(new));
    }
    (cuts, news)
}

#[test]
fn a_cut_at_any_write_or_erase_leaves_the_old_or_the_new_set_whole() {
    let sets =
        [1.0, 2.0, 3.0, 4.0].map(|kp| srnf(&[&format!("controller.srnf.kp_v_per_deg={kp}")]));
    let mut store = stored(&sets[0]);
    let mut all = (0, 0);
    let pairs = [[0, 1], [1, 2], [2, 3]].map(|pair| pair.map(|i: usize| &sets[i]));
    // A save is an erase and the words of the record. All sets have the same values.
    let words = sets[0].encode(0, &mut [0; ROOM]).unwrap().len().div_ceil(4) as u32;
    let remains = remains().count() as u32;
    for [old, new] in pairs {
        let (cuts, news) = cut_at_each(&store, Some(old), new);
        // The new set is found only if the last word was finished, or what is left of it happens to
        // be the same.
        assert_eq!(cuts, remains * (1 + words));
        assert!((1..=7).contains(&news), "{news} of {cuts}");
        store.flash().revive();
        store.save(new).unwrap();
        all.0 += cuts;
        all.1 += news;
    }
    assert_eq!(all.0, pairs.len() as u32 * remains * (1 + words));
    reliability!("cuts", pairs = pairs.len(), words, remains, cuts = all.0, news = all.1);
}

#[test]
fn a_cut_of_the_first_save_leaves_nothing_or_the_new_set() {
    let (cuts, news) = cut_at_each(&blank(), None, &srnf(&[]));
    assert!((1..=7).contains(&news), "{news} of {cuts}");
}

#[test]
fn slots_are_written_in_turn_and_the_same_set_is_not_written_again() {
    let (first, second) = (srnf(&[]), srnf(&["controller.srnf.v_ms_v=0.3"]));
    let mut store = blank();
    assert_eq!(store.load(), Err(DecodeError::Blank));
    store.save(&first).unwrap();
    let writes = store.flash().operations();
    store.save(&first).unwrap();
    assert_eq!(store.flash().operations(), writes);
    store.save(&second).unwrap();
    assert_eq!(store.load(), Ok(second.clone()));
    // Only the second slot is lost: the first set is still there.
    let mut lost = store.clone();
    lost.flash().cut(PowerCut { after: 0, remains: CutRemains::Finished });
    let _ = NorFlash::erase(lost.flash(), SECTOR, 2 * SECTOR);
    lost.flash().revive();
    assert_eq!(lost.load(), Ok(first));
}

/// `cargo xtask params` makes the sectors and a probe writes them. A store reads those, whatever
/// was saved there before.
#[test]
fn what_a_probe_writes_over_both_sectors_counts_and_is_outlived() {
    let plan = &plans("step-response", &["loop.controller=srnf"])[0];
    let [old, new] = [0.2, 0.3].map(|v| srnf(&[&format!("controller.srnf.v_ms_v={v}")]));
    let probed = parameters(plan);
    let mut store = stored(&new);
    store.save(&old).unwrap();
    let sectors = simulator::device::sectors(plan).unwrap();
    let (first, second) = sectors.split_at(SECTOR as usize);
    for (sector, at) in [(first, 0), (second, SECTOR)] {
        // A probe erases what it writes to, and skips what is erased anyway.
        NorFlash::erase(store.flash(), at, at + SECTOR).unwrap();
        let mut bytes = sector.to_vec();
        bytes.truncate(ROOM);
        bytes.resize(bytes.len().next_multiple_of(4), 0xFF);
        NorFlash::write(store.flash(), at, &bytes).unwrap();
        // One sector alone would not do: the other one's number may be higher.
        let is_whole = at > 0;
        assert_eq!(store.load() == Ok(probed.clone()), is_whole);
    }
    store.save(&new).unwrap();
    assert_eq!(store.load(), Ok(new));
}

/// One bit of a word falls.
fn spoil(flash: &mut SimulatedFlash, at: u32) {
    let mut word = [0; 4];
    flash.read(at, &mut word).unwrap();
    let bits = u32::from_le_bytes(word);
    flash.write(at, &(bits & (bits - 1)).to_le_bytes()).unwrap();
}

#[test]
fn a_damaged_set_is_reported_and_nothing_starts_by_itself_until_the_next_save() {
    let plan = &plans("step-response", &["loop.controller=srnf", "device.autostart=true"])[0];
    let parameters = simulator::device::parameters(plan).unwrap();
    let older = parameters.clone();
    let mut newer = parameters;
    newer.controller.pd.kp = 0.5;
    newer.device.autostart = false;
    let whole = {
        let mut store = stored(&older);
        store.save(&newer).unwrap();
        store
    };
    // Both sets are whole; an entry of the newest has changed; its format version has.
    for (at, is_damaged) in [(None, false), (Some(28), true), (Some(4), true)] {
        let mut store = whole.clone();
        if let Some(at) = at {
            spoil(store.flash(), SECTOR + at);
        }
        let mut simulated = SimulatedDevice::with(plan, store, Boot::default()).unwrap();
        let in_use = simulated.device.parameters().unwrap();
        assert_eq!(in_use.controller.pd.kp, if is_damaged { 1.0 } else { 0.5 });
        assert_eq!(in_use.device.autostart, is_damaged, "the older one would start by itself");
        // Its delay is a second.
        assert_eq!(simulated.ticks(200).state, State::Stopped);
        let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
        assert_eq!(client.status().unwrap().is_damaged, is_damaged);
        client.save().unwrap();
        assert!(!client.status().unwrap().is_damaged);
    }
    // What is wrong is the damage: the same set starts by itself if it is the newest and both are
    // whole, or if it is the only one.
    for mut store in [whole, stored(&newer)] {
        store.save(&older).unwrap();
        let mut simulated = SimulatedDevice::with(plan, store, Boot::default()).unwrap();
        assert_eq!(simulated.ticks(200).state, State::Armed);
    }
}
