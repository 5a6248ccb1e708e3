#!/bin/sh
# Runs docs/how-to/ensembles.md's job array on a real Slurm of one node, and compares its report with that of one run.
#
# Wants root and Debian's packages slurmctld, slurmd, slurm-client and munge. Starts its own daemons with their files in a
# directory of its own, on their usual ports, and ends them. Not a part of CI.
#
#   host-sim/cluster/slurm-check.sh target/debug/stiction
set -eu

STICTION=$(realpath "$1")
export STICTION
DIR=$(mktemp -d)
HOST=$(hostname -s)
SHARDS=3
OPTIONS="--plant rigid,thesis-axis --cases 12 --controller pd,roi"

say() { printf '%s\n' "slurm-check: $*"; }
started=""
finish() {
    for pid in $started; do kill "$pid" 2>/dev/null || true; done
    for pid in $started; do wait "$pid" 2>/dev/null || true; done
    rm -rf "$DIR"
}
trap finish EXIT INT TERM

cat > "$DIR/slurm.conf" <<CONF
ClusterName=check
SlurmctldHost=$HOST
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$DIR/munge.socket
CredType=cred/munge
StateSaveLocation=$DIR/state
SlurmdSpoolDir=$DIR/spool
SlurmctldPidFile=$DIR/slurmctld.pid
SlurmdPidFile=$DIR/slurmd.pid
SlurmctldLogFile=$DIR/slurmctld.log
SlurmdLogFile=$DIR/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MpiDefault=none
NodeName=$HOST NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$HOST Default=YES MaxTime=10 State=UP
CONF
mkdir "$DIR/state" "$DIR/spool" "$DIR/out"
export SLURM_CONF="$DIR/slurm.conf"

say "starting munged, slurmctld and slurmd in $DIR"
chmod 700 "$DIR"
dd if=/dev/urandom of="$DIR/munge.key" bs=1024 count=1 2>/dev/null
chmod 600 "$DIR/munge.key"
munged --force --foreground --socket="$DIR/munge.socket" --key-file="$DIR/munge.key" \
    --log-file="$DIR/munged.log" --pid-file="$DIR/munged.pid" --seed-file="$DIR/munge.seed" \
    >"$DIR/munged.out" 2>&1 &
started="$started $!"
sleep 1
slurmctld -D >"$DIR/slurmctld.out" 2>&1 & started="$started $!"
slurmd -D >"$DIR/slurmd.out" 2>&1 & started="$started $!"
sleep 3
sinfo

cat > "$DIR/array.sh" <<'JOB'
#!/bin/sh
export RAYON_NUM_THREADS=$SLURM_CPUS_ON_NODE
exec "$STICTION" ensemble $OPTIONS --shard "$SLURM_ARRAY_TASK_ID/$SHARDS" \
    --resume "shard-$SLURM_ARRAY_TASK_ID.csv"
JOB
cat > "$DIR/merge.sh" <<'JOB'
#!/bin/sh
"$STICTION" ensemble merge shard-*.csv --json > merged.json
JOB
export OPTIONS SHARDS
array=$(sbatch --parsable --chdir="$DIR/out" --output=%A-%a.log --array=1-$SHARDS "$DIR/array.sh")
sbatch --wait --chdir="$DIR/out" --output=merge.log --dependency="afterok:$array" \
    "$DIR/merge.sh" || { cat "$DIR"/out/*.log "$DIR"/*.log; exit 1; }

# shellcheck disable=SC2086
"$STICTION" ensemble $OPTIONS --json > "$DIR/out/whole.json"
cmp "$DIR/out/whole.json" "$DIR/out/merged.json"
say "$(ls "$DIR"/out/shard-*.csv | wc -l) shards of a job array, merged by a second job: the report is that of one run"
