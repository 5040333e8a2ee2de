#!/usr/bin/env bash
# Proves that the README's two commands pass on bare systems: builds each with debootstrap in a
# folder, copies the last commit into it, and runs there as on a new machine
#   1. the set-up by a user who is not root and has no sudo: it must say what to install
#   2. bash scripts/demo.sh
#   3. bash scripts/test.sh
# usage: fresh.sh [debian12|debian13|debian-testing|ubuntu24.04 …] [-- PYTEST ARGUMENTS]
# Without names: the three releases (Python 3.11, 3.13, 3.12; debian-testing has 3.14).
# Needs root and debootstrap; CHRMC_FRESH names the folder to work in [/var/tmp/chrmc-fresh].
# pip's configuration (its files and PIP_ variables) and proxies are those of this machine. Mounts
# and processes end with the script; the base systems stay, so that the next run starts from them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

place=${CHRMC_FRESH:-/var/tmp/chrmc-fresh}
systems=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
    systems+=("$1")
    shift
done
shift $(($# > 0))
tests=("$@")
[ ${#systems[@]} -gt 0 ] || systems=(debian12 debian13 ubuntu24.04)

fail() {
    echo "fresh.sh: $*" >&2
    exit 2
}

# Suite, the debootstrap script that builds it, and the components of a usual installation.
suite_of() {
    case $1 in
        debian12) echo bookworm sid main ;;
        debian13) echo trixie sid main ;;
        debian-testing) echo testing sid main ;;
        ubuntu24.04) echo noble gutsy main,universe ;;
        *) fail "no system $1; there are debian12, debian13, debian-testing, ubuntu24.04" ;;
    esac
}

[ "$(id -u)" -eq 0 ] || fail "root is needed to build systems"
command -v debootstrap >/dev/null || fail "install debootstrap first"
for system in "${systems[@]}"; do suite_of "$system" >/dev/null; done

# The bare system, built once.
build() {
    local base=$1 suite script components signed=()
    read -r suite script components <<<"$(suite_of "$2")"
    [ -e "$base/etc/os-release" ] && return 0
    if [ "$script" = gutsy ] && [ ! -e /usr/share/keyrings/ubuntu-archive-keyring.gpg ]; then
        echo "no ubuntu-archive-keyring here: the base system's signatures are not checked"
        signed=(--no-check-gpg)
    fi
    rm -rf "$base.partial"
    # An empty mirror is the script's own.
    debootstrap "${signed[@]}" --variant=minbase --components="$components" \
        "$suite" "$base.partial" "" "$script" >"$base.log" 2>&1 ||
        fail "$2: $(grep '^E:' "$base.log" | tail -1); see $base.log"
    mv "$base.partial" "$base"
}

# A copy of the base system with the last commit in /home/new/chrmc and this machine's way to pip.
furnish() {
    local root=$1 file
    install -d "$root/home/new/chrmc"
    git archive HEAD | tar -x -C "$root/home/new/chrmc"
    cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
    # How this machine reaches the archives, and how old a release file it takes.
    apt-config dump | grep -E '^Acquire::(Check|http|https)' >"$root/etc/apt/apt.conf.d/90here" || true
    for file in /etc/pip.conf ~/.config/pip/pip.conf ~/.pip/pip.conf; do
        [ -e "$file" ] && install -D -m 644 "$file" "$root$file"
    done
    file=$(certificates)
    [ -z "$file" ] || install -D -m 644 "$file" "$root$bundle"
    # Folders of packages that pip is told of, at their own places; an index names files beside it.
    {
        env | sed -n 's/^PIP_[A-Z_]*=//p'
        python3 -m pip config list 2>/dev/null | sed "s/^[^=]*=//; s/['\"]//g; s/\\\\n/ /g"
    } | tr ' ' '\n' | sed -n 's#^file://\(/.*\)/[^/]*$#\1#p; /^\//p' | sort -u | while read -r file; do
        if [ -d "$file" ]; then
            mkdir -p "$root$file"
            mount --bind "$file" "$root$file"
        fi
    done
}

# Certificates that pip is to trust: the system's own packages may replace those in /etc/ssl.
bundle=/etc/pip-certificates.pem
certificates() {
    echo "${PIP_CERT:-${SSL_CERT_FILE:-$(python3 -m pip config get global.cert 2>/dev/null || true)}}"
}

# Runs a command line in the system, as on a machine just started.
inside() {
    local root=$1 user=$2 name keep=()
    shift 2
    while read -r name; do
        keep+=("$name=${!name}")
    done < <(compgen -e | grep -E '^(PIP_.*|https?_proxy|HTTPS?_PROXY|no_proxy|NO_PROXY)$')
    [ ! -e "$root$bundle" ] || keep+=("PIP_CERT=$bundle")
    chroot --userspec="$user" "$root" /usr/bin/env -i \
        HOME="$([ "$user" = 0:0 ] && echo /root || echo /home/new)" LANG=C.UTF-8 TERM=dumb \
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin "${keep[@]}" \
        /bin/bash -c "cd /home/new/chrmc && $*"
}

# All of it for one system, in namespaces of its own.
try() {
    local system=$1 root=$place/$1.run base=$place/$1 said status
    build "$base" "$system"
    rm -rf --one-file-system "$root"
    cp -a "$base" "$root"
    mount --make-rprivate /
    mount --bind "$root" "$root" # as a system's root is: a place where something is mounted
    furnish "$root"
    mount -t proc proc "$root/proc"
    mount --rbind /sys "$root/sys"
    mount --rbind /dev "$root/dev"
    mount -t tmpfs tmpfs "$root/dev/shm"
    chmod 1777 "$root/tmp"

    chown -R 1000:1000 "$root/home/new"
    status=0
    said=$(inside "$root" 1000:1000 "bash scripts/demo.sh --help" 2>&1) || status=$?
    grep -q "apt-get install .*libegl1" <<<"$said" && [ "$status" -ne 127 ] ||
        fail "$system: without root the set-up ends with $status and says: $said"
    echo "$system: without root: $(head -1 <<<"$said")"
    chown -R 0:0 "$root/home/new"
    inside "$root" 0:0 "bash scripts/demo.sh"
    inside "$root" 0:0 "bash scripts/test.sh ${tests[*]@Q}"
}

if [ "${CHRMC_FRESH_INSIDE:-}" = yes ]; then
    try "${systems[0]}"
    exit
fi
mkdir -p "$place"
bad=()
for system in "${systems[@]}"; do
    echo "== $system"
    start=$SECONDS
    # The process group and mounts of a system end with it.
    CHRMC_FRESH_INSIDE=yes unshare --mount --pid --fork --kill-child \
        bash "$PWD/scripts/fresh.sh" "$system" -- "${tests[@]}" 2>&1 | tee "$place/$system.log" || bad+=("$system")
    echo "== $system: $((SECONDS - start)) s"
    rm -rf --one-file-system "$place/$system.run"
done
[ ${#bad[@]} -eq 0 ] || { echo "fresh.sh: failed on ${bad[*]}" >&2; exit 1; }
echo "passed on ${systems[*]}"
