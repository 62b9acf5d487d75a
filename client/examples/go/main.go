// Creates a session of a tumbling spacecraft, goes to a step, and streams samples:
//
//	go generate && go run . [HOST:PORT]
package main

import (
	"context"
	"encoding/binary"
	"fmt"
	"io"
	"log"
	"math"
	"os"
	"time"

	pb "example/stiefel/v1"
	"google.golang.org/grpc"
	"google.golang.org/grpc/credentials/insecure"
	"google.golang.org/protobuf/encoding/protojson"
)

//go:generate sh -c "protoc -I../../../proto --go_out=. --go_opt=paths=source_relative --go-grpc_out=. --go-grpc_opt=paths=source_relative ../../../proto/stiefel/v1/*.proto"

func must[T any](value T, err error) T {
	if err != nil {
		log.Fatal(err)
	}
	return value
}

// show prints the k-th quaternion of a tensor of doubles.
func show(step int64, tensor *pb.Tensor, k int) {
	fmt.Printf("step %d:", step)
	for at := 32 * k; at < 32*k+32; at += 8 {
		fmt.Printf(" %v", math.Float64frombits(binary.LittleEndian.Uint64(tensor.Data[at:])))
	}
	fmt.Println()
}

func main() {
	address := append(os.Args, "127.0.0.1:50551")[1]
	channel := must(grpc.NewClient(address, grpc.WithTransportCredentials(insecure.NewCredentials())))
	client := pb.NewSimulationServiceClient(channel)
	ctx, cancel := context.WithTimeout(context.Background(), time.Minute)
	defer cancel()

	scene, id, fields := &pb.Scene{}, fmt.Sprintf("go-%d", time.Now().UnixNano()), []string{"quaternion"}
	if err := protojson.Unmarshal(must(os.ReadFile("../scenes/tumbling_spacecraft.json")), scene); err != nil {
		log.Fatal(err)
	}
	must(client.CreateSession(ctx, &pb.CreateSessionRequest{SessionId: id, Scene: scene}))

	reply := must(client.Step(ctx, &pb.StepRequest{SessionId: id, To: 100, Fields: fields}))
	show(reply.Sample.Step, reply.Sample.Fields[0].Value, 0)

	stream := must(client.Stream(ctx, &pb.StreamRequest{SessionId: id, To: 1000, Every: 250, Fields: fields}))
	for part, err := stream.Recv(); err != io.EOF; part, err = stream.Recv() {
		for k, step := range must(part, err).Steps {
			show(step, part.Fields[0].Value, k)
		}
		if part.RunStatus != nil {
			fmt.Println(part.RunStatus.Outcome)
		}
	}
	must(client.DeleteSession(ctx, &pb.DeleteSessionRequest{SessionId: id}))
}
