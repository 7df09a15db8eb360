# Completion of talus-sandbox for bash: commands, their options, configurations, and the keys of --set. What the program itself
# lists is asked of it, so that nothing here has to follow a change: options from --help, keys from `talus-sandbox keys`.

# Print the long options of a command (none: of the program).
_talus_sandbox_options() {
    "$1" ${2:+"$2"} --help 2>/dev/null | sed -nE 's/^  (-[a-z],)?(--[a-z-]+)( .*)?$/\2/p'
}

# Print table.key= for every key of a configuration.
_talus_sandbox_keys() {
    "$1" keys 2>/dev/null | sed -nE '/^\[[a-z_.]+\]$/ { s/[][]//g; h }; /^  [a-z_]+ / { s/^  ([a-z_]+) .*/\1/; G; s/(.*)\n(.*)/\2.\1=/p }'
}

_talus_sandbox() {
    local program=${COMP_WORDS[0]} word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command='' k
    COMPREPLY=()
    for ((k = 1; k < COMP_CWORD; ++k)); do
        case ${COMP_WORDS[k]} in
        run | check | plan | keys) command=${COMP_WORDS[k]} && break ;;
        esac
    done
    # `mapfile` keeps names with spaces in one piece.
    case $before in
    --set)
        compopt -o nospace
        mapfile -t COMPREPLY < <(compgen -W "$(_talus_sandbox_keys "$program")" -- "$word")
        return
        ;;
    --out)
        compopt -o filenames
        mapfile -t COMPREPLY < <(compgen -d -- "$word")
        return
        ;;
    --trace | --costs | --json)
        compopt -o filenames
        mapfile -t COMPREPLY < <(compgen -f -X '!*.json' -- "$word"; compgen -d -- "$word")
        return
        ;;
    --steps | --threads | --ranks | --latency | --bandwidth | --disk) return ;; # numbers
    esac
    if [[ $word == -* ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$(_talus_sandbox_options "$program" "$command")" -- "$word")
    elif [[ -z $command ]]; then
        mapfile -t COMPREPLY < <(compgen -W 'run check plan keys' -- "$word")
    elif [[ $command != keys ]]; then
        compopt -o filenames
        mapfile -t COMPREPLY < <(compgen -f -X '!*.toml' -- "$word"; compgen -d -- "$word")
    fi
}
complete -F _talus_sandbox talus-sandbox
