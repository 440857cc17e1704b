#!/bin/bash
# slurm.sh GNOMON SOURCE: a Slurm of one node with two processors, made of Debian's daemons in a temporary folder by whoever
# runs this, root or not. Submits data/cluster/study.sbatch twice, filling one folder together and one folder each, and
# requires both to end with the bytes of a single run. Exits with 77 where Slurm is not installed.
set -eu
gnomon=$(realpath "$1")
source=$(realpath "$2")
. "$source/tests/cluster/study.sh"
PATH=$PATH:/usr/sbin:/sbin
need munged slurmctld slurmd sbatch sinfo

work=$(mktemp -d /tmp/gnomon-slurm-XXXXXX) # short: sockets have short names
daemons=
finish() {
    code=$?
    trap - EXIT
    [ -z "$daemons" ] || kill $daemons 2>/dev/null || true
    wait
    [ $code -eq 0 ] || tail -n 20 "$work"/*.log "$work"/task-* >&2 2>/dev/null || true
    rm -rf "$work"
    exit $code
}
trap finish EXIT

free_port() {
    local port
    while port=$((20000 + RANDOM)); (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; do :; done
    echo $port
}

me=$(id -un)
host=$(hostname -s)
mkdir -m 700 "$work/munge"
mkdir "$work/state" "$work/spool"
(umask 077 && head -c 1024 /dev/urandom >"$work/munge/key")
munged --foreground --force --key-file="$work/munge/key" --socket="$work/munge/socket" --pid-file="$work/munge/pid" \
    --log-file="$work/munge/log" --seed-file="$work/munge/seed" >"$work/munged.log" 2>&1 &
daemons=$!
cat >"$work/slurm.conf" <<END
ClusterName=gnomon
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$me
SlurmdUser=$me
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
NodeName=$host NodeAddr=127.0.0.1 CPUs=2
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
echo CgroupPlugin=cgroup/v1 >"$work/cgroup.conf" # named, it is not used; looked for, it must be mounted
export SLURM_CONF=$work/slurm.conf

wait_for() {
    for _ in $(seq 300); do
        "$@" >/dev/null 2>&1 && return
        sleep 0.1
    done
    echo "waited half a minute for: $*" >&2
    exit 1
}
wait_for test -S "$work/munge/socket"
slurmctld -D >"$work/slurmctld.out.log" 2>&1 &
daemons="$daemons $!"
slurmd -D >"$work/slurmd.out.log" 2>&1 &
daemons="$daemons $!"
idle() { sinfo --noheader --format=%t | grep -qx idle; }
wait_for idle

cd "$work"
write_study study.json
"$gnomon" study run study.json --output single
submit() {
    GNOMON=$gnomon timeout 240 sbatch --wait --array=1-2 --cpus-per-task=1 --output="$work/task-%A-%a" \
        "$source/data/cluster/study.sbatch" "$work/study.json" "$work/$1"
}
submit shared
check_same shared single
submit 'part-%a'
mkdir merged
cp -r part-1/. part-2/. merged
"$gnomon" study collect merged
check_same merged single
