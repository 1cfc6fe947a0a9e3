#!/bin/sh
# Makes a certificate authority and one certificate for each role, for mutual TLS on one machine or one vehicle.
# usage: certificates.sh DIRECTORY [NAME…]    NAMEs and addresses by which the learner is met; 127.0.0.1 always
set -eu
directory=$1
shift
names="IP:127.0.0.1,DNS:localhost"
for name in "$@"; do
    case $name in
        *[!0-9.]*) names="$names,DNS:$name" ;;
        *) names="$names,IP:$name" ;;
    esac
done
umask 077
mkdir -p "$directory"
cd "$directory"
openssl ecparam -name prime256v1 -genkey -noout -out ca.key
openssl req -x509 -new -key ca.key -sha256 -days 3650 -subj "/CN=incsvr authority" -out ca.pem
for role in learner sensor viewer; do
    openssl ecparam -name prime256v1 -genkey -noout | openssl pkcs8 -topk8 -nocrypt -out "$role.key"
    openssl req -new -key "$role.key" -subj "/CN=$role" -out "$role.csr"
    printf 'subjectAltName=%s\nextendedKeyUsage=serverAuth,clientAuth\n' "$names" > "$role.ext"
    openssl x509 -req -in "$role.csr" -CA ca.pem -CAkey ca.key -CAcreateserial -sha256 -days 825 \
        -extfile "$role.ext" -out "$role.pem"
    rm "$role.csr" "$role.ext"
done
