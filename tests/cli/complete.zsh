# complete.zsh PROGRAM: types the beginnings of words into a shell of its own, presses the tabulator, and looks at what
# the completion of tanor makes of the line.
zmodload zsh/zpty || exit 1
program=$1
folder=$(mktemp -d)
trap 'rm -rf $folder' EXIT
cd $folder
touch net.json notes.txt
mkdir "two words.out"
$program completion zsh > _tanor || exit 1
cat > start.zsh <<'START'
autoload -Uz compinit
compinit -u -D
source ./_tanor
bindkey '^I' complete-word
keep() { print -r -- $BUFFER > line; BUFFER= }
zle -N keep
bindkey '^X' keep
: > ready
START
zpty shell zsh -f -i
zpty -w shell "cd $folder; source ./start.zsh"

wait_for() {
  local part
  for _ in {1..300}; do
    while zpty -rt shell part; do :; done
    [[ -e $1 ]] && return 0
    sleep 0.1
  done
  print "there is no $1"
  return 1
}

# The line after the tabulator.
expect() {
  rm -f line
  zpty -n -w shell "$1"$'\t'$'\x18'
  wait_for line || return 1
  local line=$(<line)
  [[ ${line% } == "$2" ]] || { print -r -- "'$1' becomes '$line', not '$2'"; return 1 }
}

failed=0
wait_for ready || exit 1
expect 'tanor inf' 'tanor info' || failed=1
expect 'tanor run n' 'tanor run net.json' || failed=1
expect 'tanor run net.json --rep' 'tanor run net.json --report' || failed=1
expect 'tanor run net.json --method radau' 'tanor run net.json --method radau5' || failed=1
expect 'tanor view two' 'tanor view two\ words.out/' || failed=1
expect 'tanor run net.json --trajectory xyz,h' 'tanor run net.json --trajectory xyz,h5md,' || failed=1
expect 'tanor help sol' 'tanor help solve' || failed=1
zpty -d shell
exit $failed
